// SPDX-License-Identifier: MIT
// Numbers for people: SI, three digits, and a prefix that fits.
const Text = (() => {
  'use strict';
  const PREFIX = [[1e6, 'M'], [1e3, 'k'], [1, ''], [1e-3, 'm'], [1e-6, 'µ'], [1e-9, 'n']];

  // The prefix for numbers of this size.
  function prefix(size) {
    const fit = PREFIX.find(([factor]) => Math.abs(size) >= 0.9995 * factor);
    return fit || (size === 0 ? [1, ''] : PREFIX[PREFIX.length - 1]);
  }

  // Three digits: 1.16, 23.4, 873.
  function digits(x) {
    if (x === 0) return '0';
    const size = Math.abs(x);
    return x.toFixed(size < 9.995 ? 2 : size < 99.95 ? 1 : 0).replace(/^-(0[.0]*)$/, '$1');
  }

  const si = (x, unit) => {
    const [factor, letter] = prefix(x);
    return digits(x / factor) + '\u202f' + letter + unit;
  };

  // The next of 1, 2, 5, 10, ... that is at least x > 0.
  function round_up(x) {
    const power = 10 ** Math.floor(Math.log10(x));
    return [1, 2, 5, 10].map(k => k * power).find(k => k >= x * (1 - 1e-9)) || 10 * power;
  }

  // The same in smaller steps, for a colour scale.
  function round_up_a_little(x) {
    const power = 10 ** Math.floor(Math.log10(x));
    return [1, 1.5, 2, 3, 4, 5, 6, 8, 10].map(k => k * power).find(k => k >= x * (1 - 1e-9)) || 10 * power;
  }

  const GAP = ' \u00a0';  // between the numbers of a vector, where a line may end
  const count = n => n.toLocaleString('en-US');
  const mm = v => Array.from(v, x => (1e3 * x).toFixed(Math.abs(x) < 0.1 ? 2 : Math.abs(x) < 1 ? 1 : 0)).join(GAP);
  return {prefix, digits, si, round_up, round_up_a_little, count, mm, GAP};
})();
