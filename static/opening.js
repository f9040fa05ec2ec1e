// Sends the form of a link's page as soon as somebody looks at it: a page fetched ahead opens nothing.

const send = () => document.getElementById("opening").submit();

if (document.prerendering) document.addEventListener("prerenderingchange", send, { once: true });
else send();
