function number(x) {
  return typeof x === "number" && isFinite(x) ? x : NaN;
}

function absent(x) {
  return x !== x;
}

// The rounding is that of Understudy, so that equally many ticks always give the same number.
function elapsed(now, since) {
  var steps = now < 4194304 ? 1e9 : 1e6;
  return since === null ? NaN : Math.floor((now - since) * steps + 0.5) / steps;
}

function finite(x, otherwise) {
  return x - x === 0 ? x : otherwise;
}

function wrap(x, period) {
  var wrapped = finite(x, NaN) % period;
  if (wrapped < 0) { wrapped += period; }
  return wrapped >= period ? 0 : wrapped;
}

function label(x, count) {
  return x >= 0 && x < count ? Math.floor(x) : NaN;
}
