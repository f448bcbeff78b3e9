// SPDX-License-Identifier: GPL-2.0-or-later
// Texts of the page, each with its contrast, that WCAG 2 finds unreadable: below 4.5 to 1.
(() => {
  const rgb = text => text.match(/[\d.]+/g).map(Number);
  const linear = v => (v /= 255) <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
  const light = ([r, g, b]) => 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
  const ratio = (a, b) => (Math.max(light(a), light(b)) + 0.05) / (Math.min(light(a), light(b)) + 0.05);
  const probe = document.body.appendChild(document.createElement('i'));
  const named = name => { probe.style.color = `var(--${name})`; return rgb(getComputedStyle(probe).color); };
  const grounds = e => {
    for (; e; e = e.parentElement) {
      if (e.id === 'stage') return [named('ground'), named('ground-low')];
      const back = rgb(getComputedStyle(e).backgroundColor);
      if (back.length === 3 || back[3] === 1) return [back];
    }
    return [named('ground')];
  };
  const poor = [];
  let texts = 0;
  const judge = (what, ink, on) => {
    ++texts;
    const worst = Math.min(...on.map(ground => ratio(ink, ground)));
    if (worst < 4.5) poor.push(what + ' ' + worst.toFixed(2));
  };
  for (const link of ['', 'trouble']) {
    document.getElementById('link').hidden = false;
    document.getElementById('link').className = link;
    document.getElementById('link').textContent = 'link ' + link;
    document.getElementById('record').classList.toggle('on', link !== '');
    for (const e of document.querySelectorAll('body *')) {
      const own = Array.from(e.childNodes).some(n => n.nodeType === 3 && n.textContent.trim());
      if (own && !/^(SCRIPT|STYLE|NOSCRIPT)$/.test(e.tagName) && !e.disabled && !e.closest('#failed'))
        judge(e.textContent.slice(0, 30), rgb(getComputedStyle(e).color), grounds(e));
    }
  }
  for (const axis of ['axis-x', 'axis-y', 'axis-z', 'quiet'])
    judge(axis, named(axis), [named('ground'), named('ground-low')]);
  judge('plots', named('quiet'), [named('card')]);
  probe.remove();
  return texts < 60 ? ['only ' + texts] : poor;
})()
