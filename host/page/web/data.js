// SPDX-License-Identifier: MIT
// What the page carries: the scene as JSON, module and tables as base64, checked by length and CRC-32.
const Data = (() => {
  'use strict';

  function bytes_of(id) {
    const raw = atob(document.getElementById(id).textContent.trim());
    const bytes = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; ++i) bytes[i] = raw.charCodeAt(i);
    document.getElementById(id).textContent = '';
    return bytes;
  }

  // ISO-HDLC, that of zlib.
  function crc32(bytes) {
    const table = new Uint32Array(256);
    for (let n = 0; n < 256; ++n) {
      let c = n;
      for (let k = 0; k < 8; ++k) c = c & 1 ? 0xEDB88320 ^ (c >>> 1) : c >>> 1;
      table[n] = c;
    }
    let crc = 0xFFFFFFFF;
    for (let i = 0; i < bytes.length; ++i) crc = table[(crc ^ bytes[i]) & 255] ^ (crc >>> 8);
    return (crc ^ 0xFFFFFFFF) >>> 0;
  }

  // Throws an Error with advice where something is not as it was written.
  function read() {
    let scene, data, wasm;
    try {
      scene = JSON.parse(document.getElementById('scene').textContent);
      wasm = bytes_of('wasm');
      data = bytes_of('data');
    } catch (error) {
      throw new Error('its tables cannot be read (' + error.message + ')');
    }
    if (data.length !== scene.bytes || crc32(data) !== scene.crc32) throw new Error('its tables are not those that were written');
    const table = (name, Type) => {
      const {offset, bytes} = scene.tables[name];
      return new Type(data.buffer.slice(offset, offset + bytes));
    };
    return {scene, wasm: wasm.buffer, data: data.buffer, table};
  }

  const AWAY = 0x80000000;  // among the buttons of one of two fingers: it is not there

  // A servo's CSV or a path: {path [3 n], buttons [n] or null, force [3 n] or null}; of two fingers each has both in turn,
  // of a tool a path has the turn w x y z too, [7 n]. Throws an Error that names the line.
  function parse_csv(text, fingers = 1, of_tool = false) {
    const lines = text.replace(/^\uFEFF/, '').split(/\r?\n/);
    const head = lines[0].split(','), places = of => ['x', 'force_x', 'buttons', 'state'].map(name => head.indexOf(name + of));
    const columns = [places(''), places('2')].slice(0, fingers), [x, fx, held] = columns[0];
    if (x < 0 || head[x + 1] !== 'y' || head[x + 2] !== 'z') throw new Error('line 1 names no columns x,y,z');
    if (fingers === 1 && head.includes('x2')) throw new Error('it is of two fingers, and this body has one');
    const q = head.indexOf('qw'), wide = of_tool ? 7 : 3;
    if (of_tool && !['qw', 'qx', 'qy', 'qz'].every((name, a) => head[q + a] === name)) throw new Error('line 1 names no columns qw,qx,qy,qz: the hand holds a tool, which has a turn');
    if (!of_tool && q >= 0) throw new Error('it is of a tool, and this hand has fingers');
    while (lines.length > 1 && lines[lines.length - 1] === '') lines.pop();
    const n = fingers * (lines.length - 1), path = new Float32Array(wide * n), force = fx < 0 ? null : new Float32Array(3 * n);
    const buttons = held < 0 && fingers === 1 ? null : new Uint32Array(n);
    for (let i = 0; i < n; ++i) {
      const row = Math.floor(i / fingers), cell = lines[row + 1].split(','), [x_, fx_, held_, state_] = columns[i % fingers];
      if (cell.length !== head.length) throw new Error('line ' + (row + 2) + ' has ' + cell.length + ' columns, not ' + head.length);
      if (held_ >= 0) buttons[i] = number(cell[held_], row + 2);
      if (x_ < 0 || fingers === 2 && cell[state_] === '0') buttons[i] = AWAY;
      for (let a = 0; x_ >= 0 && a < 3; ++a) {
        path[wide * i + a] = number(cell[x_ + a], row + 2);
        if (force && fx_ >= 0) force[3 * i + a] = number(cell[fx_ + a], row + 2);
      }
      for (let a = 0; of_tool && a < 4; ++a) path[7 * i + 3 + a] = number(cell[q + a], row + 2);
    }
    if (n === 0) throw new Error('it holds no tick');
    return {path, buttons, force};
  }

  // A path whose places are too far from the body for the servo, and would not be in thousandths. Throws an Error.
  function refuse_millimetres(path, {workspace, fingers, tool}) {
    const wide = tool ? 7 : 3;
    const far = (i, unit_m) => Math.hypot(...workspace.origin_m.map((x, a) => unit_m * path[i + a] - x)) > workspace.limit_m;
    for (let i = 0; i < path.length; i += wide) {
      if (!far(i, 1) || far(i, 1e-3)) continue;
      const place = Array.from(path.subarray(i, i + 3), x => String(Number(x.toPrecision(6)))).join(', ');
      throw new Error('line ' + (Math.floor(i / wide / fingers) + 2) + ' (' + place +
        ') looks like millimetres, and a path is in metres: divide its places by 1000');
    }
  }

  function number(cell, line) {
    if (/^-?nan$/i.test(cell)) return NaN;
    if (/^-?inf(inity)?$/i.test(cell)) return cell[0] === '-' ? -Infinity : Infinity;
    const value = Number(cell);
    if (cell.trim() === '' || Number.isNaN(value)) throw new Error('line ' + line + ': "' + cell.slice(0, 40) + '" is no number');
    return value;
  }

  return {read, parse_csv, refuse_millimetres};
})();
