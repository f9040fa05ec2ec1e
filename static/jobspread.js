// The figures of a spread, of values in the page: as the server's summary has them, for the cases that are brushed.

const PERCENTS = [5, 25, 50, 75, 95];

// Between the two values that a share of the way through the sorted ones falls between, as numpy has it.
function percentile(sorted, percent) {
  const at = ((sorted.length - 1) * percent) / 100;
  const below = Math.floor(at);
  const above = Math.min(below + 1, sorted.length - 1);
  return sorted[below] + (at - below) * (sorted[above] - sorted[below]);
}

// No interval: who brushes chooses, and what is chosen is no random sample.
export function spreadOf(values) {
  const count = values.length;
  if (count === 0) return { count, interval: null };
  const sorted = Float64Array.from(values).sort();
  const mean = sorted.reduce((sum, v) => sum + v / count, 0);
  const squares = sorted.reduce((sum, v) => sum + (v - mean) ** 2, 0);
  return {
    count, mean, sd: count > 1 ? Math.sqrt(squares / (count - 1)) : null, least: sorted[0], most: sorted[count - 1],
    percentiles: Object.fromEntries(PERCENTS.map((p) => [p, percentile(sorted, p)])), interval: null,
  };
}
