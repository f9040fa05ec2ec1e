# The studio on one port, as a plain user; the same commands as on a developer's machine.
FROM python:3.11-slim-bookworm
RUN apt-get update && apt-get install -y --no-install-recommends make && rm -rf /var/lib/apt/lists/* \
    && useradd --create-home glider
WORKDIR /home/glider/studio
COPY --chown=glider . .
RUN mkdir /data && chown -R glider /data /home/glider/studio
USER glider
RUN make setup && make warm
# Listening beyond the container demands a token: docker run -e GLIDER_STUDIO_TOKEN=... -p 8000:8000 -v designs:/data
ENV GLIDER_STUDIO_HOST=0.0.0.0 GLIDER_STUDIO_DATA=/data
VOLUME /data
EXPOSE 8000
CMD ["make", "studio"]
