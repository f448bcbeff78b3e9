// SPDX-License-Identifier: MIT
// The page: pointer and keys in, engine beside it, picture, plots and numbers out.
(() => {
  'use strict';
  const $ = id => document.getElementById(id);
  const PUSHES_BACK = 60;  // N/m: so stiff a body is felt beside a hand of 200 N/m, and dented all the same
  const HISTORY_S = 5, CLEARANCE = 0.02, RAMP_S = 0.22;  // of the diagonal; s until a press has its depth
  const query = new URLSearchParams(location.search || location.hash.slice(1));

  const GRAB = 2, ACKNOWLEDGE = 4;  // a device's buttons
  let data, scene, engine, picture, live = null, frame = null, mode = 0;
  let tilt = null;  // of a tool, how far keys have turned it: {about the screen's axes, about its own}
  let hand = 0, turning = null, pinch = new Map(), awaiting = false, gain = 1;
  let grip = [0, 1].map(() => ({hover: null, press: null}));  // of each finger; the mouse has that of `hand`
  let by_time, by_depth, by_depth_floor, histories, replay = null, recording = false;
  const frames = [];
  let ready, about = '';
  // For whoever wants to drive the page by a program.
  const api = window.haptable = {
    ready: new Promise((resolve, reject) => { ready = {resolve, reject}; }),
    frame: () => frame,
    scene: () => scene,
    picture: () => picture,
    live: () => live,
    rate: () => frames.length < 2 ? 0 : 1000 * (frames.length - 1) / (frames[frames.length - 1] - frames[0]),
    replay: (file, index = 0) => ask('replay', {...file, mode: index, csv: true})
  };
  api.ready.catch(() => {});

  // ---- the engine: in a worker, or in the page where the browser gives none -------------------------------------------

  const waiting = new Map();
  let asked = 0;
  function ask(kind, message) {
    const id = ++asked;
    engine.postMessage({kind, id, ...message});
    return new Promise(resolve => waiting.set(id, resolve));
  }

  function start_worker() {
    const text = $('engine').textContent + '\nhaptableEngine(self);';
    const url = URL.createObjectURL(new Blob([text], {type: 'text/javascript'}));
    const worker = new Worker(url);
    worker.onmessage = event => hear(event.data);
    worker.onerror = event => {
      event.preventDefault();
      if (!frame) engine = start_here();
      open_engine();
    };
    return worker;
  }

  function start_here() {
    const script = document.createElement('script');
    script.textContent = $('engine').textContent;
    document.head.appendChild(script);
    const port = {postMessage: message => setTimeout(() => hear(message), 0), onmessage: null};
    window.haptableEngine(port);
    api.without_worker = true;
    return {postMessage: message => setTimeout(() => port.onmessage({data: message}), 0)};
  }

  function start_engine() {
    if (query.get('worker') === 'off') return start_here();
    try {
      return start_worker();
    } catch (error) {  // some browsers forbid it to a file
      return start_here();
    }
  }

  const open_engine = () => engine.postMessage({kind: 'open', wasm: data.wasm, data: data.data, scene});

  function hear(message) {
    if (message.kind === 'ready') begin();
    if (message.kind === 'frame') show(message);
    if (message.kind === 'recorded') save(message);
    if (message.kind === 'error') fail(message.text);
    if (message.id && waiting.has(message.id)) {
      waiting.get(message.id)(message);
      waiting.delete(message.id);
    }
  }

  function fail(text) {
    window.haptableFailed('This page does not work: ' + text + '.', 'Copy the file again, or make it again with haptable-view DIR --page FILE. If it stays so, the browser may be too old: it needs WebAssembly.');
    ready.reject(new Error(text));
  }

  // ---- beginning -------------------------------------------------------------------------------------------------------

  document.addEventListener('DOMContentLoaded', () => {
    if (!$('end')) return;  // said already
    setTimeout(() => {
      try {
        data = Data.read();
      } catch (error) {
        return fail(error.message);
      }
      scene = data.scene;
      try {
        picture = new Picture($('stage'), $('picture'), $('overlay'), scene, data.table, query.get('smooth') === 'on');
      } catch (error) {
        picture = null;
      }
      if (scene.tool) tilt = {by: new THREE.Quaternion(), own: 0, normal: null};
      engine = start_engine();
      open_engine();
    }, 0);
  });

  function begin() {
    if (scene.live) engine = live = new Live(engine, 112 * scene.fingers + 4 * (scene.body_modes ? scene.body_modes.modes : 0) + (scene.body ? 28 : 0), tell_live);
    histories = Array.from({length: scene.fingers}, () => new History(1000 * HISTORY_S));
    document.documentElement.classList.toggle('two', scene.fingers === 2);
    document.documentElement.classList.toggle('tool', Boolean(scene.tool));
    by_time = new Plot($('by_time'));
    by_depth = new Plot($('by_depth'));
    describe();
    controls();
    if (picture) pointer();
    else no_webgl();
    keys();
    files();
    $('loading').remove();
    if (picture) picture.draw();  // who is told that the page is ready may ask where a point is on it
    $('stage').classList.add('drawn');
    ready.resolve(true);
    if (query.get('press') === 'middle' && picture) setTimeout(press_middle, 500);  // for a picture without a hand
    requestAnimationFrame(tick);
  }

  // ---- a session elsewhere ---------------------------------------------------------------------------------------------

  const may_press = () => !live || live.yours;

  function tell_live() {
    $('link').hidden = false;
    $('link').textContent = live.text;
    $('link').classList.toggle('trouble', Boolean(live.trouble));
    if ($('hint')) $('hint').hidden = !live.yours;
    if (!live.yours) release_all();
    dress();
  }

  function buttons(event, down) {
    const button = {g: GRAB, a: ACKNOWLEDGE}[event.key.toLowerCase()];
    if (live && button && !(down && is_its_own(event))) live.press(button, down);
  }

  function no_webgl() {
    const box = document.createElement('div');
    box.id = 'failed';
    box.className = 'beside';
    box.innerHTML = '<div><h2>This browser gives no WebGL, so the body cannot be drawn.</h2><p>The servo runs all the same: replay a CSV, and its forces are plotted. To see and press the body, allow graphics acceleration in the browser\'s settings, or open the file in another browser.</p></div>';
    document.getElementById('failed').remove();
    $('stage').appendChild(box);
    $('hint').remove();
    $('legend').remove();
  }

  function describe() {
    const counts = scene.counts || {}, material = scene.material || {}, facts = [];
    if (counts.nodes) facts.push(Text.count(counts.nodes) + ' nodes', Text.count(counts.touchable_patches) + ' touchable patches');
    if (material.young_pa) facts.push('E ' + Text.si(material.young_pa, 'Pa'), 'ν ' + material.poisson);
    $('facts').textContent = facts.join(' · ');
    const columns = scene.columns, half = columns.format === 'float16';
    const servo = scene.live ? 'the session’s own servo, over LCM' : 'the C servo as WebAssembly, a tick a millisecond';
    about = 'haptable ' + scene.version + ' · ' + servo + ' · tables ' + scene.modes[0].hash +
      ' · deformation from ' + (half ? 'float16 columns, to ' + columns.error.toExponential(0) : 'float32 columns');
  }

  // ---- controls --------------------------------------------------------------------------------------------------------

  function options(select, values, words) {
    select.innerHTML = '';
    for (const value of values) select.add(new Option(words(value), value));
    select.disabled = values.length < 2;
  }

  function controls() {
    const laws = [...new Set(scene.modes.map(m => m.force))], gods = [...new Set(scene.modes.map(m => m.god_object))];
    options($('law'), laws, w => scene.titles[w]);
    options($('god'), gods, w => scene.titles[w]);
    for (const id of ['law', 'god', 'friction']) $(id).addEventListener('change', choose);
    set_mode(0);
    options($('gain'), [1, 10, 100, 1000, 10000], g => g === 1 ? 'the force itself' : 'the force × ' + Text.count(g));
    const stiffness = scene.stiffness_n_per_m;
    gain = 10 ** Math.max(0, Math.min(4, Math.round(Math.log10(PUSHES_BACK / stiffness))));
    $('gain').value = gain;
    const most_mm = Number((120 * picture_size()).toPrecision(1));
    $('depth').max = most_mm;
    $('depth').value = Math.min(5, 0.5 * most_mm);
    $('hand').value = Math.log10(scene.hand.stiffness_n_per_m / 20) / 2;
    for (const id of ['gain', 'depth', 'hand', 'exaggerate']) $(id).addEventListener('input', adjust);
    $('ghost').addEventListener('change', adjust);
    $('lines').addEventListener('change', adjust);
    $('theme').addEventListener('click', turn_theme);
    $('ask').addEventListener('click', () => $('help').showModal());
    $('record').addEventListener('click', record);
    adjust();
  }

  const picture_size = () => picture ? picture.size : 0.05;

  function set_mode(index) {
    mode = index;
    const chosen = scene.modes[mode];
    $('law').value = chosen.force;
    $('god').value = chosen.god_object;
    $('friction').checked = chosen.friction > 0;
    const rough = scene.modes.find(m => m.force === chosen.force && m.god_object === chosen.god_object && m.friction > 0);
    $('friction').disabled = !rough || !scene.modes.some(m => m.force === chosen.force && m.god_object === chosen.god_object && m.friction === 0);
    $('friction').nextElementSibling.textContent = rough ? 'friction, µ ' + rough.friction : 'friction';
  }

  function choose() {
    const fits = (m, rough) => m.force === $('law').value && m.god_object === $('god').value && (m.friction > 0) === rough;
    let index = scene.modes.findIndex(m => fits(m, $('friction').checked));
    if (index < 0) index = scene.modes.findIndex(m => m.force === $('law').value && m.god_object === $('god').value);
    if (index < 0) index = mode;
    if (recording) record();
    set_mode(index);
    engine.postMessage({kind: 'mode', index});
    for (let f = 0; f < scene.fingers; ++f) if (grip[f].hover) send_goal(f, goal_of(f), true);
    clear();
  }

  function adjust() {
    gain = Number($('gain').value);
    const stiffness = 20 * 100 ** Number($('hand').value);
    engine.postMessage({kind: 'hand', gain, stiffness_n_per_m: stiffness});
    say('hand', Text.digits(stiffness) + ' N/m');
    say('depth', Number($('depth').value).toFixed(1) + ' mm deep');
    say('exaggerate', $('exaggerate').value === '1' ? 'true to scale' : '× ' + $('exaggerate').value);
    if (!picture) return;
    picture.exaggerate = Number($('exaggerate').value);
    picture.ghost.visible = $('ghost').checked;
    picture.material.uniforms.lines.value = $('lines').checked ? 1 : 0;
    picture.dirty = true;
  }

  // What a slider stands at, for eyes and for who hears the page.
  function say(slider, text) {
    $(slider + '_is').textContent = text;
    $(slider).setAttribute('aria-valuetext', text);
  }

  function turn_theme() {
    document.documentElement.classList.toggle('dark');
    if (picture) picture.recolour();
  }

  // ---- the pointer -----------------------------------------------------------------------------------------------------

  function pointer() {
    const stage = $('stage');
    stage.addEventListener('pointerdown', down);
    stage.addEventListener('pointermove', move);
    for (const end of ['pointerup', 'pointercancel', 'lostpointercapture']) stage.addEventListener(end, up);
    stage.addEventListener('contextmenu', event => event.preventDefault());
    stage.addEventListener('wheel', wheel, {passive: false});
  }

  const place_of = event => {
    const box = $('stage').getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };

  function down(event) {
    if (event.target.closest('#player, button')) return;
    document.documentElement.classList.remove('keys');
    $('stage').focus({preventScroll: true});
    const [x, y] = place_of(event), hit = picture.pick(x, y);
    pinch.set(event.pointerId, [x, y]);
    try {
      $('stage').setPointerCapture(event.pointerId);
    } catch (error) { /* an event that no pointer made */ }
    const presses = !replay && may_press() && event.button === 0 && !event.shiftKey && hit && hit.touchable;
    if (pinch.size === 2 && !(presses && scene.fingers === 2 && grip[hand].press)) {
      release_all();
      turning = null;
      return;
    }
    if (!presses) {
      turning = {id: event.pointerId, x, y};
      return dress();
    }
    const free = [hand, 1 - hand].find(f => f < scene.fingers && !(grip[f].press && pinch.has(grip[f].press.id)));
    if (free !== undefined) press_at(free, hit, event);
  }

  function press_at(finger, hit, event) {
    const far = is_far(finger, hit);
    grip[finger] = {hover: hit, press: {id: event ? event.pointerId : -1, since: performance.now(), pressure: pressure_of(event)}};
    send_goal(finger, goal_of(finger), far);
    $('hint').classList.add('away');
    dress();
  }

  // The finger is not led there: its way would be through the body.
  function is_far(finger, hit) {
    const {hover} = grip[finger];
    return !hover || Math.hypot(...hit.at_m.map((v, a) => v - hover.at_m[a])) > 0.25 * picture.size;
  }

  // Which finger a pointer presses; -1: none.
  const pressed_by = event => grip.findIndex(({press}) => press && press.id === event.pointerId);

  // A pen says how hard it presses; a mouse and most fingers do not.
  const pressure_of = event => event && event.pointerType === 'pen' && event.pressure > 0 ? 2 * event.pressure : 1;

  function move(event) {
    const [x, y] = place_of(event);
    if (pinch.has(event.pointerId)) {
      const before = pinch.get(event.pointerId);
      if (pinch.size === 2 && pressed_by(event) < 0 && !turning) return pinched(event.pointerId, before, [x, y]);
      pinch.set(event.pointerId, [x, y]);
    }
    if (turning && event.pointerId === turning.id) {
      picture.turn(x - turning.x, y - turning.y);
      Object.assign(turning, {x, y});
      return;
    }
    if (replay || !may_press()) return;
    const hit = picture.pick(x, y), pressed = pressed_by(event);
    if (pressed >= 0) {
      const one = grip[pressed];
      one.press.pressure = pressure_of(event);
      one.hover = hit && hit.touchable ? hit : {...one.hover, at_m: picture.on_plane(x, y, one.hover.at_m)};
      return;
    }
    if (!grip[hand].press && event.pointerType !== 'touch') {
      const begins = hit && hit.touchable && is_far(hand, hit);
      if (hit && hit.touchable) grip[hand].hover = hit;
      if (grip[hand].hover) send_goal(hand, goal_of(hand), begins);
    }
    $('stage').classList.toggle('on_body', Boolean(hit && hit.touchable));
  }

  function pinched(id, before, now) {
    const other = [...pinch].find(([key]) => key !== id)[1];
    const length = p => Math.hypot(p[0] - other[0], p[1] - other[1]);
    picture.zoom(length(before) / Math.max(length(now), 1));
    picture.turn(0.5 * (now[0] - before[0]), 0.5 * (now[1] - before[1]));
    pinch.set(id, now);
  }

  function up(event) {
    pinch.delete(event.pointerId);
    if (turning && event.pointerId === turning.id) turning = null;
    if (pressed_by(event) >= 0) release(pressed_by(event));
    dress();
  }

  function release(finger) {
    grip[finger].press = null;
    send_goal(finger, goal_of(finger));
  }

  const release_all = () => grip.forEach(({press}, finger) => { if (press) release(finger); });

  function dress() {
    $('stage').classList.toggle('pressing', grip.some(({press}) => press));
    $('stage').classList.toggle('turning', turning !== null);
  }

  function wheel(event) {
    event.preventDefault();
    const notches = Math.max(-3, Math.min(3, event.deltaY / 100));
    if (grip[hand].press) deeper(-notches);
    else picture.zoom(1.12 ** notches);
  }

  function deeper(steps) {
    const slider = $('depth');
    slider.value = Math.max(0, Math.min(Number(slider.max), Number(slider.value) + steps * Number(slider.max) / 40));
    adjust();
  }

  // Where the hand wants the finger: above the surface, or, pressed, below it.
  function goal_of(finger, least = 0) {
    const {hover, press} = grip[finger], above = CLEARANCE * picture.size, low = below_handle();
    if (!press) return hover.at_m.map((v, a) => v + (low + above) * hover.normal[a]);
    const t = Math.min(1, Math.max(least, (performance.now() - press.since) / (1e3 * RAMP_S))), share = t * t * t * (10 + t * (-15 + 6 * t));
    const depth = Math.min(1e-3 * Number($('depth').value) * press.pressure, 2e-3 * Number($('depth').max));
    return hover.at_m.map((v, a) => v + (low + above - share * (above + depth)) * hover.normal[a]);
  }

  function send_goal(finger, at, place = false) {
    engine.postMessage({kind: 'goal', finger, at, place, turn: scene.tool ? turn_of(finger) : null});
  }

  // A tool's lowest point is at the surface when its handle is so far above; of a finger 0.
  const below_handle = () => scene.tool ? Math.max(...scene.tool.point_m.map(r => -r[2])) : 0;

  // A tool faces the surface where the pointer is, or where a press began; keys turn it from there: w x y z.
  function turn_of(finger) {
    const {hover, press} = grip[finger];
    if (!press || !tilt.normal) tilt.normal = hover.normal;
    const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), new THREE.Vector3(...tilt.normal).normalize());
    turn.premultiply(tilt.by).multiply(new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3(0, 0, 1), tilt.own));
    return [turn.w, turn.x, turn.y, turn.z];
  }

  // Turns a tool by steps of 5 degrees about the screen's axes, to the right and up, and about its own.
  function turn_tool(right, up, own) {
    const step = Math.PI / 36, [x, y] = picture.axes();
    tilt.by.premultiply(new THREE.Quaternion().setFromAxisAngle(x, step * right)).premultiply(new THREE.Quaternion().setFromAxisAngle(y, step * up)).normalize();
    tilt.own += step * own;
    if (grip[hand].hover) send_goal(hand, goal_of(hand));
  }

  // Leaves the finger where it is, as deep as it was to go, and takes up the other one.
  function other_finger() {
    if (scene.fingers === 1 || replay || !may_press()) return;
    if (grip[hand].press) send_goal(hand, goal_of(hand, 1));
    grip[hand] = {hover: null, press: null};
    hand = 1 - hand;
    dress();
  }

  // Keys that what has the focus takes itself: a list all letters, a slider those that move it.
  function is_its_own(event) {
    const {tagName, type} = event.target;
    return event.ctrlKey || event.metaKey || event.altKey || tagName === 'SELECT' ||
      tagName === 'INPUT' && type === 'range' && /^(Arrow|Page|Home|End)/.test(event.key) || $('help').open;
  }

  function keys() {
    window.addEventListener('keyup', event => buttons(event, false));
    window.addEventListener('keydown', event => {
      buttons(event, true);
      document.documentElement.classList.add('keys');
      if (is_its_own(event)) return;
      const turns = {ArrowLeft: [0, -1, 0], ArrowRight: [0, 1, 0], ArrowUp: [-1, 0, 0], ArrowDown: [1, 0, 0], '<': [0, 0, 1], '>': [0, 0, -1]}[event.key];
      if (scene.tool && picture && !replay && turns && (event.shiftKey || event.key.length === 1)) {
        event.preventDefault();
        return turn_tool(...turns);
      }
      const act = {
        ArrowLeft: () => picture.turn(24, 0), ArrowRight: () => picture.turn(-24, 0), ArrowUp: () => picture.turn(0, 24),
        ArrowDown: () => picture.turn(0, -24), '+': () => picture.zoom(0.9), '=': () => picture.zoom(0.9), '-': () => picture.zoom(1.1),
        w: () => deeper(1), s: () => deeper(-1), Home: home, p: press_middle, r: record, f: other_finger,
        l: turn_theme, '?': () => $('help').showModal()
      }[event.key.length === 1 ? event.key.toLowerCase() : event.key];
      if (!act || (!picture && !/[rl?]/.test(event.key))) return;
      event.preventDefault();
      act();
    });
  }

  // Puts the camera back, and a body that nothing holds.
  function home() {
    picture.home();
    if (scene.tool) tilt = {by: new THREE.Quaternion(), own: 0, normal: null};
    if (!scene.body || live || replay) return;
    grip = grip.map(() => ({hover: null, press: null}));
    if (recording) record();
    engine.postMessage({kind: 'anew'});
  }

  function press_middle() {
    if (grip[hand].press) return release(hand);
    const hit = picture.pick(0.5 * picture.width, 0.5 * picture.height);
    if (hit && hit.touchable && !replay && may_press()) press_at(hand, hit, null);
  }

  // ---- a picture at a time ---------------------------------------------------------------------------------------------

  function tick(now) {
    requestAnimationFrame(tick);
    frames.push(now);
    if (frames.length > 120) frames.shift();
    grip.forEach(({press}, finger) => { if (press) send_goal(finger, goal_of(finger)); });
    if (replay && replay.playing) advance_replay(now);
    if (!awaiting) {
      awaiting = true;
      engine.postMessage({kind: 'frame'});
    }
    if (picture) picture.draw();
    spare(now);
  }

  // Where pictures come too slowly (no graphics processor), they get coarser: at most to half.
  function spare(now) {
    if (!picture || query.get('ratio')) return;
    const since = now - (spare.last === undefined ? now : spare.last), pause = now - (spare.seen || now) > 3000;  // of a hidden tab
    spare.seen = now;
    spare.count = (spare.count || 0) + 1;
    if (since < 1500 && spare.last !== undefined && !pause) return;
    if (!pause && since > 0 && 1000 * spare.count / since < 40) picture.coarser();
    Object.assign(spare, {last: now, count: 0});
  }

  function show(message) {
    awaiting = false;
    if (live) Object.assign(message, {goal: live.goals[0], dropped: live.lost});
    if (live && message.second) message.second.goal = live.goals[1];
    frame = message;
    const n = message.samples.length / message.sample;
    for (let i = 0; i < n; ++i) {
      const s = message.samples.subarray(i * message.sample, (i + 1) * message.sample);
      if (!replay) histories[i % scene.fingers].add(s[1], s[2], s[0]);
    }
    const now = performance.now();
    if (picture && changed(message)) picture.show(message, $('colour').value);
    // Eyes read no faster; and where the processor draws all, texts and plots must not take the body's time.
    if (now - (show.last || 0) < Math.max(100, 4000 / Math.max(api.rate(), 4))) return;
    show.last = now;
    numbers(message);
    plots();
    legend();
  }

  // Whether it would draw another picture than the last.
  function changed(message) {
    const of = one => one ? one.state + ' ' + one.finger.join() + one.god.join() + one.goal : '';
    const pose = (message.pose ? message.pose.centre.join() + message.pose.turn.join() : '') + (message.tool ? message.tool.turn.join() : '');
    const key = of(message) + of(message.second) + pose + message.swung.join() + $('colour').value + $('exaggerate').value;
    const other = key !== changed.last;
    changed.last = key;
    return other;
  }

  const STATE = ['no finger yet', 'free', 'in contact', 'no position', 'in contact, limited', 'fault'];

  function numbers(f) {
    const size = Math.hypot(...f.force), contact = f.contact, depth = depth_of(f);
    $('force').innerHTML = output(f, '') + (f.second ? ' ' + output(f.second, 'second') : '');
    // What a servo that is gone has said last is not what is.
    const stale = Boolean(live && live.trouble && f.state !== 0);
    for (const id of ['felt', 'stage']) $(id).classList.toggle('stale', stale);
    const state = one => (stale ? 'not heard; was: ' : '') + (STATE[one.state] || String(one.state));
    const lines = [
      ['state', state(f)],
      ['force x y z', contact ? vector(f.force, size, 'N') : '–'],
      ['depth', contact ? Text.si(depth, 'm') : '–'],
      ['stiffness felt', contact && depth > 1e-6 ? Text.si(size / depth, 'N/m') : '–'],
      ['finger, mm', f.state === 1 || contact ? Text.mm(f.finger) : '–'],
      ['god-object, mm', contact ? Text.mm(f.god) : '–'],
      ['patch: nodes', contact ? f.patch + ': ' + Array.from(f.vertex, v => scene.node[v]).join(Text.GAP) : '–'],
      ...(f.tool ? of_tool(f.tool) : []),
      ...(f.second ? of_second(f.second, state(f.second)) : [])
    ];
    $('numbers').innerHTML = lines.map(([name, text]) => '<dt>' + name + '</dt><dd>' + text + '</dd>').join('');
    $('about').textContent = Math.round(api.rate()) + ' pictures/s' + (f.dropped > 0 ? ', ' + Text.count(f.dropped) + ' ms lost' : '') + ' · ' + about;
    if (recording) $('session').textContent = 'recording: ' + (f.recorded / 1000).toFixed(1) + ' s';
  }

  // Of a tool, of the point that is deepest.
  const depth_of = f => f.tool ? Math.max(...f.tool.points.map(depth_of)) : f.contact ? Math.hypot(...f.finger.map((v, a) => v - f.god[a])) : 0;

  function output(f, name) {
    const [value, unit] = Text.si(Math.hypot(...f.force), 'N').split('\u202f');
    return '<output class="' + name + '">' + value + '</output> <span>' + unit + '</span>';
  }

  function of_tool(tool) {
    const size = Math.hypot(...tool.torque), touching = tool.points.filter(one => one.contact).length;
    return [
      ['torque x y z', size > 0 ? vector(tool.torque, size, 'N m') : '–'],
      ['points that touch', touching + ' of ' + tool.points.length]
    ];
  }

  function of_second(f, state) {
    return [
      ['second finger', state],
      ['its force x y z', f.contact ? vector(f.force, Math.hypot(...f.force), 'N') : '–'],
      ['its depth', f.contact ? Text.si(depth_of(f), 'm') : '–']
    ];
  }

  function vector(v, size, unit) {
    const [factor, letter] = Text.prefix(size);
    return Array.from(v, x => Text.digits(x / factor)).join(Text.GAP) + '\u202f' + letter + unit;
  }

  const clear = () => histories.forEach(history => history.clear());

  const good_m = () => (scene.small_strain || {}).depth_m || 0;

  function plots() {
    const floor_m = 1e-3, floor_n = Math.max(scene.stiffness_n_per_m * floor_m, 1e-6);
    const seconds = replay ? Math.max(0.1, replay.count / 1000) : HISTORY_S;
    if (replay) return replay_plots(seconds, floor_n, floor_m);
    draw_by_time(by_time, histories, seconds, floor_n);
    draw_by_depth(by_depth, histories, floor_n, floor_m, good_m());
  }

  function legend() {
    if (!picture) return;
    const load = $('colour').value === 'load', end = picture.colour_end;
    const steps = Array.from({length: 9}, (_, i) => '#' + scene.colors.substr(6 * Math.round(i / 8 * 255), 6)).join(',');
    const key = load + ' ' + end + document.documentElement.className;
    if (key === legend.last) return;
    legend.last = key;
    const ball = (name, text) => '<i style="background:var(--' + name + ')"></i><span>' + text + '</span>';
    const part = (color, text) => '<i class="part" style="background:' + color + '"></i><span>' + text + '</span>';
    const marks = picture.mark, has = bits => marks.some(m => bits(m));
    $('legend').innerHTML = (load ? 'load on a node' : 'displacement') +
      '<div class="bar" style="background:linear-gradient(90deg,' + steps + ')"></div><div class="ends"><span>0</span><span>' +
      (end > 0 ? Text.si(end, load ? 'N' : 'm') : '') + '</span></div><div class="keys">' +
      ball('finger', scene.tool ? 'tool (ring: hand)' : 'finger (ring: hand)') + (scene.fingers === 2 ? ball('second-finger', 'second finger') : '') +
      ball('god-object', 'god-object') + ball('force', scene.tool ? 'force on the hand' : 'force on the finger') +
      (has(m => m & 2) ? part('repeating-linear-gradient(135deg,var(--held) 0 3px,var(--quiet) 3px 5px)', 'held still') : '') +
      (has(m => !(m & 3)) ? part('var(--not-touchable)', 'not touchable') : '') + '</div>';
  }

  // ---- record and replay -----------------------------------------------------------------------------------------------

  function record() {
    if (replay) return;
    recording = !recording;
    $('record').classList.toggle('on', recording);
    $('record').textContent = recording ? 'stop and save' : 'record';
    engine.postMessage({kind: recording ? 'begin_record' : 'end_record'});
    if (recording) clear();
  }

  function save(message) {
    const chosen = scene.modes[message.mode];
    const name = [scene.name, chosen.force, chosen.god_object].concat(chosen.friction > 0 ? ['friction'] : [], chosen.hash).join('-') + '.csv';
    api.saved = {name, csv: message.csv};
    const link = document.createElement('a');
    link.href = URL.createObjectURL(new Blob([message.csv], {type: 'text/csv'}));
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    $('session').textContent = Text.count(message.ticks) + ' ticks saved as ' + name + '. haptable-view DIR --csv draws it.';
  }

  function files() {
    $('replay').addEventListener('click', () => $('file').click());
    $('file').addEventListener('change', event => read_file(event.target.files[0]));
    document.addEventListener('dragover', event => event.preventDefault());
    document.addEventListener('drop', event => {
      event.preventDefault();
      read_file(event.dataTransfer.files[0]);
    });
    $('play').addEventListener('click', () => set_playing(!replay.playing));
    $('seek').addEventListener('input', event => {
      set_playing(false);
      seek(Number(event.target.value));
    });
    $('live').addEventListener('click', end_replay);
  }

  function read_file(file) {
    if (!file) return;
    file.text().then(text => api.play(text, file.name)).catch(error => { $('session').textContent = file.name + ': ' + error.message; });
    $('file').value = '';
  }

  // Replays the text of a CSV in the chosen mode; gives how many of its forces are the same, bit for bit.
  api.play = async (text, name = 'the file') => {
    const {path, buttons, force} = Data.parse_csv(text, scene.fingers, Boolean(scene.tool)), step = 3 * scene.fingers;
    Data.refuse_millimetres(path, scene);
    if (recording) record();
    const answer = await ask('replay', {path, buttons, mode, play: true});
    const bits = a => new Uint32Array(a.buffer);
    let same = 0;
    if (force) {
      const [a, b] = [bits(force), bits(answer.force)];
      for (let i = 0; i < force.length; i += step) same += a.subarray(i, i + step).every((bits_, k) => bits_ === b[i + k]) ? 1 : 0;
    }
    replay = {count: answer.series.length / 2 / scene.fingers, at: 0, playing: true, series: answer.series, last: performance.now()};
    $('seek').max = replay.count - 1;
    show_player(true);
    $('hint').classList.add('away');
    $('session').textContent = name + ': ' + Text.count(replay.count) + ' ticks. ' + (!force ? 'A path: it has no forces to compare.' :
      same === replay.count ? 'Its forces are the same here, in every bit.' :
        Text.count(replay.count - same) + ' of its forces are others here: another body, mode or build of the tables.');
    set_playing(true);
    return {ticks: replay.count, same: force ? same : null};
  };

  function show_player(yes) {
    $('player').hidden = !yes;
    if (picture) Object.assign(picture, {lifted: yes, dirty: true});
  }

  function set_playing(yes) {
    replay.playing = yes;
    replay.last = performance.now();
    if (yes && replay.at >= replay.count - 1) replay.at = 0;
    $('play').textContent = yes ? '❚❚' : '▶';
  }

  function advance_replay(now) {
    seek(Math.min(replay.at + Math.max(0, now - replay.last), replay.count - 1));
    replay.last = now;
    if (replay.at >= replay.count - 1) set_playing(false);
  }

  function seek(at) {
    replay.at = at;
    $('seek').value = at;
    $('played').textContent = (at / 1000).toFixed(2) + ' / ' + (replay.count / 1000).toFixed(2) + ' s';
    engine.postMessage({kind: 'show', at: Math.floor(at)});
  }

  function end_replay() {
    replay = null;
    show_player(false);
    $('session').textContent = 'A CSV of the servo or of a path, dropped here, is replayed.';
    engine.postMessage({kind: 'live'});
    clear();
  }

  function replay_plots(seconds, floor_n, floor_m) {
    const n = replay.count, series = replay.series, fingers = scene.fingers, at = Math.floor(replay.at);
    const step = Math.max(1, Math.floor(n / 1500)), xs = [];
    const of = (what, i, finger) => series[2 * (fingers * i + finger) + what];
    const each = what => histories.map((_, finger) => xs.map((_x, k) => of(what, k * step, finger)));
    for (let i = 0; i < n; i += step) xs.push(i / 1000);
    const ys = each(0), ds = each(1), most = lists => lists.flat().reduce((a, b) => Math.max(a, b), 0);
    const top = Text.round_up(Math.max(floor_n, 1.05 * most(ys))), deep = Text.round_up(Math.max(floor_m, 1.02 * most(ds)));
    let c = by_time.begin();
    by_time.axes(c, {x_end: seconds, x_label: s => String(Number(s.toPrecision(3))), y_end: top, y_unit: 'N'});
    ys.forEach((y, finger) => {
      by_time.line(c, xs, y, FINGERS[finger]);
      by_time.dot(c, at / 1000, of(0, at, finger), FINGERS[finger]);
    });
    c = by_depth.begin();
    by_depth.axes(c, {x_end: deep, x_label: m => String(Number((1e3 * m).toPrecision(3))), y_end: top, y_unit: 'N'});
    draw_good(by_depth, c, good_m());
    ds.forEach((d, finger) => {
      by_depth.line(c, d, ys[finger].map((f, i) => d[i] > 0 ? f : NaN), FINGERS[finger], {alpha: 0.8, width: 1.3});
      by_depth.dot(c, of(1, at, finger), of(0, at, finger), FINGERS[finger]);
    });
  }
})();
