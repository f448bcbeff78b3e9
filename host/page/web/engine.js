// SPDX-License-Identifier: MIT
// The servo, the hand and equation 8, in a worker (or, where there is none, in the page itself): messages in, messages
// out. `port` is what has postMessage and onmessage. A tick is a millisecond; time runs by the clock of the machine.
function haptableEngine(port) {
  'use strict';
  const WORDS = 28;                     // of struct page_tick (host/page/wasm/page.c), one for each finger
  const POSE = 7;                       // of struct page_pose at a record's end, of a body that nothing holds
  const GRIP = 14;                      // of struct page_grip there, of a tool, behind the ticks of its points
  const AWAY = 0x80000000;              // among the buttons of one of two fingers: it is not there
  const FINGER = 5, ALPHA = 8, GOD = 11, FORCE = 14, BUTTONS = 26, FAULTS = 27, SILENT = 0, CONTACT = 2, REJECTED = 3, LIMITED = 4;
  const MOST_TICKS = 40;                // that are made up for after a pause: time beyond is dropped, and told
  const ROOM = 4096;                    // ticks of one call
  const GOAL_MS = 25;                   // the pointer comes in steps of a picture: a hand goes between them
  const SAMPLE = 5;                     // numbers a tick and finger that the plots get

  let wasm, scene, models = [], couplings = [], body_modes_of = [], tools = [], mode = 0, fingers = 1, stride = WORDS;
  let points = 0, wide = 3;             // of a tool; numbers of a path's tick
  let swings = 0;                       // modes of a body that rings: a number of each, behind the fingers' ticks
  let ticks_at = 0, path_at = 0, buttons_at = 0, from_at = 0, to_at = 0;
  let goal = [null, null], goal_before = [null, null], gain = 1;
  let turn = null, turn_before = [1, 0, 0, 0];  // of a tool: w x y z
  let last_ms = 0, tick = 0, dropped = 0;
  let latest = null;
  let samples = [], record = null, played = null;

  const floats = (at, n) => new Float32Array(wasm.memory.buffer, at, n);
  const words = (at, n) => new Uint32Array(wasm.memory.buffer, at, n);
  const doubles = (at, n) => new Float64Array(wasm.memory.buffer, at, n);
  const reals = (tick_words, at, n) => new Float32Array(tick_words.buffer, tick_words.byteOffset + 4 * at, n);
  const real = (tick_words, at) => reals(tick_words, at, 3);

  function reserve(bytes) {
    const at = wasm.page_reserve(bytes);
    if (at === 0) throw new Error('the browser gives no memory for ' + Math.ceil(bytes / 1e6) + ' MB of tables');
    return at;
  }

  function keep(data, table) {
    const at = reserve(table.bytes);
    new Uint8Array(wasm.memory.buffer, at, table.bytes).set(new Uint8Array(data, table.offset, table.bytes));
    return at;
  }

  // What the servo made of tables; 0 where it refused them.
  function whole(at, name) {
    if (at === 0) throw new Error('the tables of ' + name + ' are damaged: make the page again');
    return at;
  }

  async function open(message) {
    const module = await WebAssembly.instantiate(message.wasm, {});
    wasm = module.instance.exports;
    scene = message.scene;
    fingers = scene.fingers;
    swings = scene.body_modes ? scene.body_modes.modes : 0;
    points = scene.tool ? scene.tool.point_m.length : 0;
    wide = points ? 7 : 3 * fingers;
    stride = (fingers + points) * WORDS + swings + (scene.body ? POSE : 0) + (points ? GRIP : 0);
    ticks_at = reserve(4 * stride * ROOM);
    path_at = reserve(4 * wide * ROOM);
    buttons_at = reserve(4 * fingers * ROOM);
    from_at = reserve(24 * fingers);
    to_at = reserve(24 * fingers);
    const table = scene.tables, data = message.data;
    for (const one of scene.modes) {
      const model = whole(wasm.page_model(keep(data, table[one.model]), table[one.model].bytes), one.model);
      models.push(model);
      const beside = (of, name, read) => name ? whole(read(of, keep(data, table[name]), table[name].bytes), name) : 0;
      couplings.push(beside(model, one.coupling, wasm.page_coupling));
      body_modes_of.push(beside(model, one.body_modes, wasm.page_body_modes));
      tools.push(points ? beside(couplings[couplings.length - 1], one.tool, wasm.page_tool) : 0);
    }
    if (table.columns) {
      const at = keep(data, table.columns), half = scene.columns.format === 'float16';
      wasm.page_columns(scene.columns.columns, scene.columns.rows, scene.columns.unit_m_per_n, half ? 0 : at, half ? at : 0);
    }
    if (table.spread_begin)
      wasm.page_spread(...['vertex_control', 'edge_control', 'spread_begin', 'spread_column', 'spread_weight']
        .map(name => keep(data, table[name])));
    if (swings > 0) wasm.page_shapes(swings, keep(data, table.mode_rows));
    if (scene.body) whole(wasm.page_body(keep(data, table.body), table.body.bytes), 'the body that nothing holds');
    choose(0);
    const hand = scene.hand;
    for (let f = 0; f < fingers; ++f)
      doubles(wasm.page_hand(f), 7).set([hand.mass_kg, hand.damping_n_s_per_m, hand.friction_n, hand.max_force_n,
        hand.encoder_step_m, hand.stiffness_n_per_m, hand.hand_damping_n_s_per_m]);
    port.postMessage({kind: 'ready'});
  }

  function choose(index) {
    mode = index;
    goal = [null, null];
    wasm.page_spreads(scene.modes[mode].force === 'pressure-mask' ? 1 : 0);
    begin();
  }

  // What a mode's servo has beside its model. A tool brings its coupling.
  const beside = index => [points ? 0 : couplings[index], body_modes_of[index], tools[index]];

  // A new session: the servo knows no finger, and feels nothing until it comes from outside.
  function begin() {
    whole(wasm.page_begin(models[mode], ...beside(mode)), 'the state of a session');
    tick = dropped = 0;
    samples = [];
    latest = new Uint32Array(stride);
    if (points) reals(latest, stride - 4, 1)[0] = reals(latest, stride - GRIP, 1)[0] = 1;  // not turned
    if (!scene.body) return;
    real(latest, stride - POSE).set(scene.body.rest_centre);
    real(latest, stride - 4)[0] = 1;  // not turned
  }

  // ---- live ---------------------------------------------------------------------------------------------------------

  function advance(now_ms) {
    let due = Math.floor(now_ms - last_ms);
    if (due <= 0) return;
    last_ms += due;
    if (due > MOST_TICKS) {
      dropped += due - MOST_TICKS;
      due = MOST_TICKS;
    }
    if (goal.every(at => at === null) || played !== null) return;
    const share = 1 - Math.exp(-due / GOAL_MS);
    for (let f = 0; f < fingers; ++f) {
      const from = goal_before[f] || [0, 0, 0], next = goal[f] ? from.map((x, a) => x + share * (goal[f][a] - x)) : from;
      doubles(from_at + 24 * f, 3).set(from);
      doubles(to_at + 24 * f, 3).set(next);
      if (goal[f]) goal_before[f] = next;
    }
    if (points && turn) turn_by(share);
    wasm.page_feel(from_at, to_at, gain, away(), due, ticks_at);
    note(words(ticks_at, stride * due), due);
  }

  // The hand turns a tool by a share of the way to its goal, the shorter way around.
  function turn_by(share) {
    const along = turn.reduce((sum, x, a) => sum + x * turn_before[a], 0), way = along < 0 ? turn.map(x => -x) : turn;
    const next = turn_before.map((x, a) => x + share * (way[a] - x)), size = Math.hypot(...next);
    turn_before = next.map(x => x / size);
    wasm.page_turn(...turn_before, 0);
  }

  // Marks the hands that nobody holds in a tick, of two. One that is alone is there, and may have no position.
  function away() {
    words(buttons_at, fingers).set(goal.slice(0, fingers).map(at => fingers === 2 && at === null ? AWAY : 0));
    return buttons_at;
  }

  function note(made, count) {
    for (let i = 0; i < count; ++i) {
      const record_ = made.subarray(stride * i, stride * (i + 1));
      for (let f = 0; f < fingers; ++f) sample(record_.subarray(WORDS * f), goal[f], pose_of(record_));
    }
    latest = made.slice(stride * (count - 1));
    if (record !== null) record.push(made.slice());
    tick += count;
  }

  // In contact, be its force limited or not.
  const touches = t => t[0] === CONTACT || t[0] === LIMITED;
  const length = v => Math.hypot(v[0], v[1], v[2]);

  // How far the modes of a body that rings have swung, of a record.
  const swung_of = t => new Float32Array(t.buffer, t.byteOffset + 4 * WORDS * fingers, swings);

  // Where a body that nothing holds is: {centre, turn}, of a record.
  const pose_of = t => scene.body ? {centre: real(t, stride - POSE), turn: new Float32Array(t.buffer, t.byteOffset + 4 * (stride - 4), 4)} : null;

  // A point of its frame: centre + turn (x - rest_centre) turn*.
  function to_world(x, pose) {
    if (!pose) return x;
    const [w, ...v] = pose.turn, r = scene.body.rest_centre.map((c, a) => x[a] - c);
    const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    const t = cross(v, r), u = cross(v, t);
    return Float32Array.from(pose.centre, (c, a) => c + r[a] + 2 * (w * t[a] + u[a]));
  }

  // From the god-object to the finger, of a tick in contact.
  function dent(t, pose) {
    const x = real(t, FINGER), g = to_world(real(t, GOD), pose);
    return [x[0] - g[0], x[1] - g[1], x[2] - g[2]];
  }

  // What touches of a hand: its finger, or of its tool each point.
  const contacts_of = t => (points ? Array.from({length: points}, (_, i) => t.subarray(WORDS * (1 + i))) : [t]).filter(touches);

  // contact or not, |F|, depth below the god-object, |goal - finger|, energy of the spring u . F / 2
  function sample(t, at, pose) {
    const f = real(t, FORCE), x = real(t, FINGER), felt = contacts_of(t).map(one => {
      const u = dent(one, pose), n = real(one, FORCE);
      return {depth: length(u), stored: -0.5 * (u[0] * n[0] + u[1] * n[1] + u[2] * n[2])};
    });
    const finger_known = t[0] !== SILENT && t[0] !== REJECTED;
    samples.push(touches(t) ? 1 : 0, length(f), Math.max(0, ...felt.map(one => one.depth)),
      finger_known && at ? Math.hypot(at[0] - x[0], at[1] - x[1], at[2] - x[2]) : 0,
      felt.reduce((sum, one) => sum + one.stored, 0));
  }

  // The hand is somewhere else at once: the servo gets a tick without a position, so that no way there is felt.
  function place(f, at) {
    wasm.page_place(f, at[0], at[1], at[2]);
    goal[f] = null;
    const at_now = goal.slice(0, fingers).flatMap((one, other) => Array.from(one ? real(latest.subarray(WORDS * other), FINGER) : [NaN, NaN, NaN]));
    if (points) {
      turn_before = turn || turn_before;
      wasm.page_turn(...turn_before, 1);
      at_now.push(...turn_before);
    }
    floats(path_at, wide).set(at_now);
    wasm.page_replay(path_at, away(), 1, ticks_at);
    goal[f] = goal_before[f] = at;
    note(words(ticks_at, stride), 1);
  }

  function displacement(tick_words) {
    if (!scene.columns) return null;
    words(ticks_at, stride).set(tick_words);
    // Of a tool, the loads of its points: the hand's is that of one of them.
    const at = wasm.page_displace(ticks_at + (points ? 4 * WORDS : 0), points || fingers);
    return floats(at, 3 * scene.columns.rows).slice();
  }

  // In world coordinates, but for the loads.
  const view = (t, at, pose) => ({
    state: t[0], contact: touches(t), patch: t[1] | 0, finger: real(t, FINGER).slice(), god: to_world(real(t, GOD), pose).slice(),
    force: real(t, FORCE).slice(), alpha: real(t, ALPHA).slice(), vertex: Int32Array.from(t.slice(2, 5)),
    nodal: new Float32Array(t.slice(17, 26).buffer), goal: at
  });

  // The tool: where it is, the torque on the hand, and the points that touch, by their god-objects.
  const tool_of = t => !points ? null : {
    torque: Array.from(real(t, stride - GRIP + 4)), position: Array.from(real(t, stride - 7)), turn: Array.from(reals(t, stride - 4, 4)),
    points: Array.from({length: points}, (_, i) => view(t.subarray(WORDS * (1 + i), WORDS * (2 + i)), null, null))
  };

  // What is the first finger's stands in the frame itself; `second`: that of another one.
  function frame() {
    if (played === null) advance(performance.now());
    const shown = played === null ? latest : played.ticks.subarray(stride * played.at, stride * (played.at + 1));
    const u = displacement(shown), plotted = new Float32Array(samples), pose = pose_of(shown);
    samples = [];
    port.postMessage({
      kind: 'frame', tick, dropped, mode, samples: plotted, sample: SAMPLE, ...view(shown, goal[0], pose),
      second: fingers === 1 ? null : view(shown.subarray(WORDS), goal[1], pose), tool: tool_of(shown),
      swung: Array.from(swung_of(shown)), pose: pose && {centre: Array.from(pose.centre), turn: Array.from(pose.turn)},
      recorded: record === null ? -1 : record.reduce((sum, piece) => sum + piece.length / stride, 0),
      played: played === null ? -1 : played.at, displacement: u
    }, u ? [u.buffer] : []);
  }

  // ---- recorded -----------------------------------------------------------------------------------------------------

  // All ticks of a path [3 n] from a servo that knows no finger: what `servo --replay` gives, bit for bit.
  function run(path, buttons, in_mode) {
    const count = path.length / wide, all = new Uint32Array(stride * count);
    whole(wasm.page_begin(models[in_mode], ...beside(in_mode)), 'the state of a session');
    for (let begun = 0; begun < count; begun += ROOM) {
      const now = Math.min(ROOM, count - begun), of = (array, n) => array.subarray(n * begun, n * (begun + now));
      floats(path_at, wide * now).set(of(path, wide));
      const held = words(buttons_at, fingers * now).fill(0);
      if (buttons) held.set(of(buttons, fingers));
      wasm.page_replay(path_at, buttons_at, now, ticks_at);
      all.set(words(ticks_at, stride * now), stride * begun);
    }
    begin();
    return all;
  }

  // How C prints %.9g, ties to even: a float32 has them at its tenth digit.
  function nine(x) {
    if (Number.isNaN(x)) return 'nan';
    if (!Number.isFinite(x)) return x > 0 ? 'inf' : '-inf';
    if (x === 0) return Object.is(x, -0) ? '-0' : '0';
    let [digits, exponent] = Math.abs(x).toExponential(8).split('e');
    const [exact, power] = Math.abs(x).toExponential(40).split('e');
    if (/^50*$/.test(exact.slice(10)) && (digits.charCodeAt(9) & 1)) {  // rounded up to an odd digit
      digits = exact.slice(0, 10);
      exponent = power;
    }
    exponent = Number(exponent);
    let text = digits.replace('.', '');
    if (exponent < -4 || exponent >= 9) {
      const rest = text.slice(1).replace(/0+$/, '');
      const sign = exponent < 0 ? '-' : '+', size = String(Math.abs(exponent)).padStart(2, '0');
      text = text[0] + (rest ? '.' + rest : '') + 'e' + sign + size;
    } else if (exponent < 0) {
      text = '0.' + '0'.repeat(-exponent - 1) + text.replace(/0+$/, '');
    } else {
      const rest = text.slice(exponent + 1).replace(/0+$/, '');
      text = text.slice(0, exponent + 1) + (rest ? '.' + rest : '');
    }
    return (x < 0 ? '-' : '') + text;
  }

  // The servo's CSV (docs/SPEC.md), byte for byte.
  function csv(pieces) {
    const names = ',x,y,z,contact,node_i,node_j,node_k,alpha_i,alpha_j,alpha_k,god_x,god_y,god_z,force_x,force_y,force_z,buttons,state,faults';
    const three_of = name => ['x', 'y', 'z'].map(a => ',' + name + '_' + a).join('');
    const of_tool = ',qw,qx,qy,qz' + three_of('torque') + three_of('tool') + ',tool_qw,tool_qx,tool_qy,tool_qz' +
      Array.from({length: points}, (_, i) => names.slice(6, names.indexOf(',buttons')).replace(/(?=,)|$/g, '_p' + (i + 1)).slice(('_p' + (i + 1)).length)).join('');
    const lines = ['tick' + names + (fingers === 2 ? names.replace(/(?=,)|$/g, '2').slice(1) : '') + (points ? of_tool : '') +
      Array.from({length: swings}, (_, k) => ',mode_' + (k + 1)).join('') + (scene.body ? ',body_x,body_y,body_z,turn_w,turn_x,turn_y,turn_z' : '')];
    const contact = t => {
      const three = at => Array.from(real(t, at), nine).join(',');
      const nodes = [2, 3, 4].map(k => (t[k] | 0) < 0 ? -1 : scene.node[t[k]]);
      return [touches(t) ? 1 : 0, nodes.join(','), three(ALPHA), three(GOD), three(FORCE)].join(',');
    };
    const columns = t => [Array.from(real(t, FINGER), nine).join(','), contact(t), t[BUTTONS], t[0], t[FAULTS]].join(',');
    for (const piece of pieces)
      for (let i = 0; i < piece.length; i += stride) {
        const row = [lines.length - 1];
        for (let f = 0; f < fingers; ++f) row.push(columns(piece.subarray(i + WORDS * f, i + WORDS * (f + 1))));
        const whole = piece.subarray(i, i + stride), pose = pose_of(whole);
        if (points) row.push(...Array.from(reals(whole, stride - GRIP, GRIP), nine));
        for (let p = 1; p <= points; ++p) row.push(contact(whole.subarray(WORDS * p, WORDS * (p + 1))));
        row.push(...Array.from(swung_of(whole), nine));
        if (pose) row.push(...Array.from(pose.centre, nine), ...Array.from(pose.turn, nine));
        lines.push(row.join(','));
      }
    return lines.join('\n') + '\n';
  }

  const answers = {
    open,
    mode: m => choose(m.index),
    goal: m => {
      const f = m.finger || 0;
      turn = m.turn || turn;
      if (goal[f] === null || m.place) place(f, m.at);
      goal[f] = m.at;
    },
    // The body where it was made, and no finger.
    anew: () => choose(mode),
    hand: m => {
      gain = m.gain;
      for (let f = 0; f < fingers; ++f) doubles(wasm.page_hand(f), 7).set([m.stiffness_n_per_m], 5);
    },
    // Ticks of a servo elsewhere, as its page_tick.
    feed: m => note(new Uint32Array(m.ticks), m.ticks.byteLength / (4 * stride)),
    frame,
    begin_record: () => {
      begin();
      record = [];
    },
    end_record: () => {
      const pieces = record || [];
      record = null;
      port.postMessage({kind: 'recorded', csv: csv(pieces), mode, ticks: pieces.reduce((n, p) => n + p.length / stride, 0)});
    },
    // For tests and for a file that was dropped: {path, buttons, mode, play}; of two fingers each has both in turn.
    replay: m => {
      const ticks = run(m.path, m.buttons, m.mode);
      const n = fingers * m.path.length / wide, force = new Float32Array(3 * n), god = new Float32Array(3 * n);
      const series = new Float32Array(2 * n);
      for (let i = 0; i < n; ++i) {
        const record_ = ticks.subarray(stride * Math.floor(i / fingers)), t = record_.subarray(WORDS * (i % fingers));
        const f = real(t, FORCE), pose = pose_of(record_.subarray(0, stride)), g = to_world(real(t, GOD), pose);
        force.set(f, 3 * i);
        god.set(g, 3 * i);
        series[2 * i] = length(f);
        series[2 * i + 1] = Math.max(0, ...contacts_of(t).map(one => length(dent(one, pose))));
      }
      if (m.play) played = {ticks, at: 0};
      port.postMessage({kind: 'replayed', id: m.id, ticks: m.words ? ticks : null, force, god, series,
        csv: m.csv ? csv([ticks]) : null});
    },
    show: m => { if (played) played.at = Math.min(m.at, played.ticks.length / stride - 1); },
    live: () => {
      played = null;
      last_ms = performance.now();
    }
  };

  const fail = error => port.postMessage({kind: 'error', text: String(error && error.message || error)});
  port.onmessage = async event => {
    try {
      await answers[event.data.kind](event.data);
    } catch (error) {
      fail(error);
    }
  };
  last_ms = performance.now();
  setInterval(() => {
    try {
      if (wasm && scene) advance(performance.now());
    } catch (error) {
      fail(error);
    }
  }, 4);
}
