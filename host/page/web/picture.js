// SPDX-License-Identifier: MIT
// The body, the finger and its force, drawn by three.js. Lengths of the scene are metres over the body's diagonal.
const OVERLAY = 240;  // CSS pixels
class Picture {
  // Throws where the browser gives no WebGL. smooth: four samples of a pixel, over the page's ground, whoever draws.
  constructor(stage, canvas, overlay, scene, table, smooth) {
    Object.assign(this, {stage, canvas, overlay, scene, inked: []});
    this.q = scene.surface.patches;
    this.rest = table('rest', Float32Array);
    this.patch = table('patch', Int32Array);
    this.normal_of = table('normal_of', Int32Array);
    this.row = table('row', Int32Array);
    this.surface_node = table('surface_node', Int32Array);
    this.mark = table('mark', Uint8Array);
    this.plain = !smooth && Picture.is_software();
    this.renderer = new THREE.WebGLRenderer({canvas, antialias: !this.plain, alpha: !this.plain, powerPreference: 'high-performance'});
    this.measure();
    this.world = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(26, 1, 0.05, 60);
    this.build_surface();
    this.build_markers();
    if (scene.tool) this.build_tool(scene.tool, table('tool_surface', Float32Array));
    if (scene.body && scene.body.floor) this.build_floor(scene.body.floor);
    this.recolour();
    this.pose = null;
    this.home();
    this.share = 1;
    this.exaggerate = 1;
    this.colour_end = 0;
    this.force_end = 0;
    this.dirty = true;
  }

  // Whether the processor draws: then four samples of a pixel take twice the time of one, and what lies under a picture
  // is drawn and mixed with it for a quarter more.
  static is_software() {
    const gl = document.createElement('canvas').getContext('webgl'), info = gl && gl.getExtension('WEBGL_debug_renderer_info');
    return Boolean(info) && /swiftshader|llvmpipe|softpipe|software|basic render/i.test(gl.getParameter(info.UNMASKED_RENDERER_WEBGL));
  }

  measure() {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < this.rest.length; ++i) {
      low[i % 3] = Math.min(low[i % 3], this.rest[i]);
      high[i % 3] = Math.max(high[i % 3], this.rest[i]);
    }
    this.low = low;
    this.high = high;
    this.centre = low.map((x, a) => 0.5 * (x + high[a]));
    this.size = Math.hypot(...low.map((x, a) => high[a] - x));
    this.thinnest = Math.min(...low.map((x, a) => high[a] - x));
  }

  // What has a colour of its own: `color` of its material, or of a uniform's value.
  ink(name, color) {
    this.inked.push({name, color});
    return color;
  }

  // As the page's colours are now (host/base/colors.inc, by --name).
  recolour() {
    const style = getComputedStyle(document.documentElement);
    for (const {name, color} of this.inked) color.set(style.getPropertyValue('--' + name).trim());
    this.dirty = true;
  }

  scaled(x) { return new THREE.Vector3(...this.centre.map((c, a) => (x[a] - c) / this.size)); }

  // ---- the surface ---------------------------------------------------------------------------------------------------

  build_surface() {
    const corners = 3 * this.q, geometry = new THREE.BufferGeometry();
    const area = new Float32Array(3 * corners), look = new Float32Array(2 * corners), crease = new Float32Array(3 * corners);
    for (let i = 0; i < corners; ++i) {
      const mark = this.mark[Math.floor(i / 3)];
      area[3 * i + i % 3] = 1;
      look[2 * i + 1] = mark & 2 ? 2 : mark & 1 ? 0 : 1;  // held, touchable, neither
      for (let c = 0; c < 3; ++c) crease[3 * i + c] = mark & (4 << c) ? 1 : 0;
    }
    const attribute = (name, array, width) => {
      const made = new THREE.BufferAttribute(array, width);
      geometry.setAttribute(name, made);
      return made;
    };
    this.position = attribute('position', new Float32Array(3 * corners), 3);
    this.normal = attribute('normal', new Float32Array(3 * corners), 3);
    this.look = attribute('look', look, 2);
    attribute('area', area, 3);
    attribute('crease', crease, 3);
    this.node_m = new Float32Array(this.rest);  // deformed
    this.load = new Float32Array(this.rest.length / 3);
    this.place_of_node = new Map(Array.from(this.surface_node, (node, i) => [node, i]));
    this.map = this.colour_map();
    this.material = new THREE.ShaderMaterial({
      extensions: {derivatives: true},
      uniforms: {map: {value: this.map}, plain: {value: this.ink('not-touchable', new THREE.Color())}, held: {value: this.ink('held', new THREE.Color())},
        lines: {value: 1}, line_color: {value: new THREE.Color(0x0b0d14)}, pixel: {value: 1}},
      vertexShader: `
        attribute vec2 look;
        attribute vec3 area, crease;
        varying vec3 v_eye, v_normal, v_area, v_crease;
        varying vec2 v_look;
        void main() {
          vec4 seen = modelViewMatrix * vec4(position, 1.0);
          v_eye = seen.xyz;
          v_normal = normalMatrix * normal;
          v_area = area;
          v_crease = crease;
          v_look = look;
          gl_Position = projectionMatrix * seen;
        }`,
      fragmentShader: `
        varying vec3 v_eye, v_normal, v_area, v_crease;
        varying vec2 v_look;
        uniform sampler2D map;
        uniform vec3 plain, held, line_color;
        uniform float lines, pixel;
        const vec3 key = vec3(-0.40, 0.71, 0.58), fill = vec3(0.86, 0.05, 0.51);
        void main() {
          vec3 n = normalize(gl_FrontFacing ? v_normal : -v_normal), to_eye = normalize(-v_eye);
          vec3 base = texture2D(map, vec2(clamp(v_look.x, 0.0, 1.0) * (255.0 / 256.0) + 0.5 / 256.0, 0.5)).rgb;
          if (v_look.y > 1.5) {  // held still: hatched
            float hatch = smoothstep(0.42, 0.58, abs(fract((gl_FragCoord.x + gl_FragCoord.y) / (9.0 * pixel)) - 0.5) * 2.0);
            base = mix(held * 0.6, held, hatch);
          } else if (v_look.y > 0.5) base = plain;
          base *= base;
          float diffuse = 0.40 + 0.10 * (0.5 + 0.5 * n.y) + 0.46 * max(dot(n, key), 0.0) + 0.22 * max(dot(n, fill), 0.0);
          float s = max(dot(n, normalize(key + to_eye)), 0.0), s4 = s * s * s * s, s16 = s4 * s4 * s4 * s4, shine = s16 * s16 * s4;
          vec3 lit = sqrt(base * diffuse + 0.07 * shine);
          vec3 height = 1.0 / max(fwidth(v_area), 1e-6);
          vec3 half_px = 0.5 * pixel * (1.0 + 0.9 * v_crease);
          vec3 line = clamp(half_px + 0.5 - v_area * height, 0.0, 1.0) * (0.34 + 0.40 * v_crease);
          float fade = smoothstep(1.5, 9.0, min(height.x, min(height.y, height.z)));
          gl_FragColor = vec4(mix(lit, line_color, lines * fade * max(line.x, max(line.y, line.z))), 1.0);
        }`
    });
    this.body = new THREE.Mesh(geometry, this.material);
    this.body.frustumCulled = false;
    this.world.add(this.body);
    this.ghost = this.rest_lines();
    this.world.add(this.ghost);
    this.rest_face = new Float32Array(3 * this.q);
    this.fill(true);
    this.rest_normal = new Float32Array(this.normal.array);
  }

  colour_map() {
    const hex = this.scene.colors, n = hex.length / 6, rgb = new Uint8Array(4 * n);
    for (let i = 0; i < n; ++i) {
      for (let k = 0; k < 3; ++k) rgb[4 * i + k] = parseInt(hex.substr(6 * i + 2 * k, 2), 16);
      rgb[4 * i + 3] = 255;
    }
    const map = new THREE.DataTexture(rgb, n, 1, THREE.RGBAFormat);
    map.minFilter = map.magFilter = THREE.LinearFilter;
    map.needsUpdate = true;
    return map;
  }

  // The edges of the rest shape, once each.
  rest_lines() {
    const seen = new Set(), at = [];
    for (let i = 0; i < this.patch.length; ++i) {
      const a = this.patch[i], b = this.patch[i - i % 3 + (i + 1) % 3], name = Math.min(a, b) * 1e6 + Math.max(a, b);
      if (seen.has(name)) continue;
      seen.add(name);
      for (const node of [a, b]) at.push(...this.scaled(this.rest.subarray(3 * node, 3 * node + 3)).toArray());
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(at), 3));
    const lines = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({color: 0x808a9c, transparent: true, opacity: 0.45, depthWrite: false}));
    lines.visible = false;
    return lines;
  }

  // A tool as it looks, or, of points that are given, a ball each; and a mark for each point that touches.
  build_tool({point_m}, corners) {
    this.tool = new THREE.Group();
    const scaled = x => x / this.size;
    if (corners.length > 0) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', new THREE.BufferAttribute(corners.map(scaled), 3));
      geometry.computeVertexNormals();
      this.tool.add(new THREE.Mesh(geometry, this.inked_material(THREE.MeshLambertMaterial, 'finger', {transparent: true, opacity: 0.6, side: THREE.DoubleSide})));
    }
    const ball = new THREE.SphereBufferGeometry(corners.length > 0 ? 0.004 : 0.01, 16, 10);
    for (const r of point_m) {
      const point = new THREE.Mesh(ball, this.inked_material(THREE.MeshLambertMaterial, 'finger'));
      point.position.set(...r.map(scaled));
      this.tool.add(point);
    }
    this.touching = point_m.map(() => this.marker(new THREE.SphereBufferGeometry(1, 16, 10), 'god-object', 0.009));
    this.tool.visible = false;
    for (const mark of this.touching) mark.visible = false;
    this.world.add(this.tool);
  }

  place_tool({position, turn, points}, known) {
    const [w, x, y, z] = turn;
    this.tool.visible = known;
    this.tool.position.copy(this.scaled(position));
    this.tool.quaternion.set(x, y, z, w);
    points.forEach((point, i) => {
      this.touching[i].visible = point.contact;
      if (point.contact) this.touching[i].position.copy(this.scaled(point.god));
    });
  }

  // The screen's axes in the world: to the right, up.
  axes() {
    const [x, y] = [new THREE.Vector3(), new THREE.Vector3()];
    this.camera.matrixWorld.extractBasis(x, y, new THREE.Vector3());
    return [x, y];
  }

  // What a body rests on that nothing holds.
  build_floor({normal, height}) {
    const up = new THREE.Vector3(...normal), floor = new THREE.GridHelper(6, 30, 0x8792a8, 0xb4bccb);
    floor.material.transparent = true;
    floor.material.opacity = 0.5;
    floor.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), up);
    const below = up.dot(new THREE.Vector3(...this.centre)) - height;
    floor.position.copy(up).multiplyScalar(-below / this.size);
    this.world.add(floor);
  }

  // A body that nothing holds, where it is: a point x at rest is at centre + turn (x - rest_centre) turn*.
  place({centre, turn}) {
    const rest = this.scene.body.rest_centre, [w, x, y, z] = turn, q = new THREE.Quaternion(x, y, z, w);
    const moved = new THREE.Vector3(...this.centre.map((c, a) => c - rest[a])).applyQuaternion(q);
    this.pose = {centre: new THREE.Vector3(...centre), rest: new THREE.Vector3(...rest), q, back: q.clone().inverse()};
    for (const part of [this.body, this.ghost]) {
      part.quaternion.copy(q);
      part.position.copy(moved).add(this.pose.centre).sub(new THREE.Vector3(...this.centre)).divideScalar(this.size);
    }
  }

  // Rest positions and the displacements [rows, 3] of equation 8; without them, the rest shape.
  deform(u) {
    let largest = 0;
    for (let i = 0; i < this.row.length; ++i) {
      const r = 3 * this.row[i];
      let size = 0;
      for (let a = 0; a < 3; ++a) {
        const move = u && r >= 0 ? u[r + a] : 0;
        size += move * move;
        this.node_m[3 * i + a] = this.rest[3 * i + a] + this.exaggerate * move;
      }
      this.moved[i] = Math.sqrt(size);
      largest = Math.max(largest, this.moved[i]);
    }
    return largest;
  }

  get moved() { return this.moved_m || (this.moved_m = new Float32Array(this.row.length)); }

  // Corners, normals by the angles at each node, split at creases. `at_rest`: these are what patches are turned over from.
  fill(at_rest = false) {
    this.turned = false;
    const normals = new Float32Array(3 * this.scene.surface.normals), p = this.position.array, size = this.size, node = this.node_m;
    const [cx, cy, cz] = this.centre;
    for (let q = 0; q < this.q; ++q) {
      const at = 9 * q;
      for (let c = 0; c < 3; ++c) {
        const n = 3 * this.patch[3 * q + c];
        p[at + 3 * c] = (node[n] - cx) / size;
        p[at + 3 * c + 1] = (node[n + 1] - cy) / size;
        p[at + 3 * c + 2] = (node[n + 2] - cz) / size;
      }
      const ax = p[at + 3] - p[at], ay = p[at + 4] - p[at + 1], az = p[at + 5] - p[at + 2];
      const bx = p[at + 6] - p[at], by = p[at + 7] - p[at + 1], bz = p[at + 8] - p[at + 2];
      const nx = ay * bz - az * by, ny = az * bx - ax * bz, nz = ax * by - ay * bx, twice = Math.hypot(nx, ny, nz) || 1, face = this.rest_face;
      if (at_rest) face.set([nx, ny, nz], 3 * q);
      else if (nx * face[3 * q] + ny * face[3 * q + 1] + nz * face[3 * q + 2] < 0) this.turned = true;
      for (let c = 0; c < 3; ++c) {
        const i = at + 3 * c, j = at + 3 * ((c + 1) % 3), k = at + 3 * ((c + 2) % 3);
        const dot = (p[j] - p[i]) * (p[k] - p[i]) + (p[j + 1] - p[i + 1]) * (p[k + 1] - p[i + 1]) + (p[j + 2] - p[i + 2]) * (p[k + 2] - p[i + 2]);
        const w = Math.atan2(twice, dot) / twice, to = 3 * this.normal_of[3 * q + c];
        normals[to] += w * nx;
        normals[to + 1] += w * ny;
        normals[to + 2] += w * nz;
      }
    }
    for (let i = 0; i < 3 * this.q; ++i) {
      const from = 3 * this.normal_of[i];
      const length = Math.hypot(normals[from], normals[from + 1], normals[from + 2]) || 1;
      for (let a = 0; a < 3; ++a) this.normal.array[3 * i + a] = normals[from + a] / length;
    }
    this.position.needsUpdate = this.normal.needsUpdate = true;
  }

  // The colours: `value` [nodes] over its end.
  paint(value, end) {
    for (let i = 0; i < this.patch.length; ++i) this.look.array[2 * i] = end > 0 ? value[this.patch[i]] / end : 0;
    this.look.needsUpdate = true;
  }

  // ---- finger, god-object, hand, arrow ---------------------------------------------------------------------------------

  build_markers() {
    this.world.add(new THREE.AmbientLight(0xffffff, 0.75));
    const lamp = new THREE.DirectionalLight(0xffffff, 0.6);
    lamp.position.set(-0.5, -0.6, 1.2);
    this.world.add(lamp);
    this.fingers = Array.from({length: this.scene.fingers}, (_, finger) => this.build_finger(['finger', 'second-finger'][finger]));
  }

  // A material in the colour of that name.
  inked_material(Material, name, rest) {
    const material = new Material(rest);
    this.ink(name, material.color);
    return material;
  }

  build_finger(name) {
    const sphere = new THREE.SphereBufferGeometry(1, 32, 20), arrow = new THREE.Group();
    const ring = new THREE.Mesh(new THREE.TorusBufferGeometry(1, 0.1, 10, 40), this.inked_material(THREE.MeshBasicMaterial, name, {transparent: true, opacity: 0.9, depthTest: false}));
    ring.scale.setScalar(0.02);
    ring.renderOrder = 4;
    const shaft = this.arrow_part(arrow, new THREE.CylinderBufferGeometry(0.0055, 0.0055, 1, 20).translate(0, 0.5, 0));
    const head = this.arrow_part(arrow, new THREE.ConeBufferGeometry(0.018, 0.055, 28).translate(0, 0.0275, 0));
    this.world.add(ring, arrow);
    const made = {finger: this.marker(sphere, name, 0.016), god: this.marker(sphere, 'god-object', 0.013), ring,
      spring: this.polyline(name), dent: this.polyline('force'), arrow};
    for (const part of Object.values(made)) part.visible = false;
    return {...made, shaft, head};
  }

  // Drawn twice: as it is, and half transparent where the body hides it.
  marker(geometry, name, radius) {
    const group = new THREE.Group();
    group.add(new THREE.Mesh(geometry, this.inked_material(THREE.MeshLambertMaterial, name)));
    const hidden = new THREE.Mesh(geometry, this.inked_material(THREE.MeshLambertMaterial, name, {transparent: true, opacity: 0.45, depthTest: false}));
    hidden.renderOrder = 2;
    group.add(hidden);
    group.scale.setScalar(radius);
    this.world.add(group);
    return group;
  }

  arrow_part(arrow, geometry) {
    const both = new THREE.Group();
    for (const hidden of [false, true]) {
      const mesh = new THREE.Mesh(geometry, this.inked_material(THREE.MeshLambertMaterial, 'force', {transparent: hidden, opacity: hidden ? 0.5 : 1, depthTest: !hidden}));
      mesh.renderOrder = hidden ? 3 : 0;
      both.add(mesh);
    }
    arrow.add(both);
    return both;
  }

  // Between two points, over the body: set by stretch.
  polyline(name) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(6), 3));
    const line = new THREE.Line(geometry, this.inked_material(THREE.LineBasicMaterial, name, {transparent: true, opacity: 0.8, depthTest: false}));
    line.frustumCulled = false;
    line.renderOrder = 3;
    this.world.add(line);
    return line;
  }

  stretch(line, from, to) {
    line.geometry.attributes.position.array.set([...from.toArray(), ...to.toArray()]);
    line.geometry.attributes.position.needsUpdate = true;
  }

  // A moment of the session (engine.js, "frame"). colour: "displacement" or "load".
  show(frame, colour) {
    if (frame.pose) this.place(frame.pose);
    const felt = frame.second ? [frame, frame.second] : [frame];
    const largest = this.deform(frame.displacement);
    this.fill();
    // Elsewhere nobody sees the inside.
    this.material.side = this.turned || this.exaggerate * largest > 0.25 * this.thinnest ? THREE.DoubleSide : THREE.FrontSide;
    let value = this.moved, size = largest;
    if (colour === 'load') {
      this.load.fill(0);
      for (const one of frame.tool ? frame.tool.points : felt) this.add_load(one);
      value = this.load;
      size = this.load.reduce((a, b) => Math.max(a, b), 0);
    }
    if (colour !== this.colour) this.colour_end = 0;
    this.colour = colour;
    if (size > this.colour_end) this.colour_end = Text.round_up_a_little(size);
    this.paint(value, this.colour_end);
    felt.forEach((one, finger) => this.mark_finger(this.fingers[finger], one, frame.played < 0));
    if (frame.tool) {
      const mark = this.fingers[0];
      this.place_tool(frame.tool, mark.finger.visible);
      mark.finger.visible = mark.god.visible = mark.dent.visible = false;  // a handle is within its tool
    }
    this.dirty = true;
  }

  // Where two fingers load one node, what both give.
  add_load(one) {
    for (let c = 0; one.contact && c < 3; ++c) {
      const at = this.place_of_node.get(this.scene.node[one.vertex[c]]);
      if (at !== undefined) this.load[at] += Math.hypot(one.nodal[3 * c], one.nodal[3 * c + 1], one.nodal[3 * c + 2]);
    }
  }

  mark_finger(mark, frame, is_now) {
    const contact = frame.contact, known = frame.state === 1 || contact, force = Math.hypot(...frame.force);
    mark.finger.visible = known;
    mark.god.visible = mark.dent.visible = contact;
    mark.ring.visible = mark.spring.visible = known && frame.goal !== null && is_now;
    if (known) mark.finger.position.copy(this.scaled(frame.finger));
    if (contact) {
      mark.god.position.copy(this.scaled(frame.god));
      this.stretch(mark.dent, mark.god.position, mark.finger.position);
    }
    if (mark.ring.visible) {
      mark.ring.position.copy(this.scaled(frame.goal));
      this.stretch(mark.spring, mark.ring.position, mark.finger.position);
    }
    if (force > this.force_end) this.force_end = Text.round_up_a_little(force);
    const length = this.force_end > 0 ? 0.3 * force / this.force_end : 0;
    mark.arrow.visible = contact && length > 0.004;
    if (!mark.arrow.visible) return;
    const head = Math.min(1, length / 0.11);
    mark.arrow.position.copy(mark.god.position);
    mark.arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3(...frame.force).normalize());
    mark.shaft.scale.set(head, Math.max(length - 0.05 * head, 1e-4), head);
    mark.head.position.y = Math.max(length - 0.055 * head, 0);
    mark.head.scale.setScalar(head);
  }

  // ---- the eye ---------------------------------------------------------------------------------------------------------

  home() {
    Object.assign(this, {azimuth: -58, elevation: 26, distance: 2.55});
    this.dirty = true;
  }
  turn(dx, dy) {
    this.azimuth -= 0.35 * dx;
    this.elevation = Math.max(-89, Math.min(89, this.elevation + 0.35 * dy));
    this.dirty = true;
  }
  zoom(factor) {
    this.distance = Math.max(0.6, Math.min(12, this.distance * factor));
    this.dirty = true;
  }

  coarser() { this.share = Math.max(0.5, 0.8 * this.share); }

  aim() {
    const box = this.stage.getBoundingClientRect(), ratio = this.share * Math.min(window.devicePixelRatio || 1, 2);
    const [w, h] = [Math.max(1, Math.round(box.width)), Math.max(1, Math.round(box.height))];
    this.sharp = window.devicePixelRatio || 1;  // of the text over the picture
    if (w !== this.width || h !== this.height || ratio !== this.ratio) {
      Object.assign(this, {width: w, height: h, ratio});
      this.renderer.setPixelRatio(ratio);
      this.renderer.setSize(w, h, false);
      Object.assign(this.overlay, {width: Math.min(w, OVERLAY) * this.sharp, height: h * this.sharp});
      this.camera.aspect = w / h;
      this.dirty = true;
      this.overlaid = '';  // a canvas that gets a size is empty
    }
    const az = this.azimuth * Math.PI / 180, el = this.elevation * Math.PI / 180;
    const far = this.distance * Math.max(1, 1.25 / this.camera.aspect);
    this.camera.position.set(far * Math.cos(el) * Math.cos(az), far * Math.cos(el) * Math.sin(az), far * Math.sin(el));
    this.camera.up.set(0, 0, 1);
    this.camera.lookAt(0, 0, 0);
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
    this.far = far;
    for (const mark of this.fingers) mark.ring.quaternion.copy(this.camera.quaternion);
    this.material.uniforms.pixel.value = ratio;
  }

  draw() {
    this.aim();
    if (!this.dirty) return;
    this.dirty = false;
    const ground = getComputedStyle(document.documentElement).getPropertyValue('--ground').trim();
    this.renderer.setClearColor(this.plain ? new THREE.Color(ground) : 0x000000, this.plain ? 1 : 0);
    this.renderer.render(this.world, this.camera);
    this.draw_overlay();
  }

  // Axes and a scale bar, over the picture's right edge; anew where the eye has moved.
  draw_overlay() {
    const style = getComputedStyle(document.documentElement), ink = style.getPropertyValue('--quiet').trim();
    const key = [this.width, this.height, this.sharp, this.azimuth, this.elevation, this.far, this.lifted, ink].join();
    if (key === this.overlaid) return;
    this.overlaid = key;
    const c = this.overlay.getContext('2d', {willReadFrequently: true});
    c.setTransform(this.sharp, 0, 0, this.sharp, 0, 0);
    c.clearRect(0, 0, this.width, this.height);
    c.translate(Math.min(OVERLAY - this.width, 0), 0);
    c.font = '12px system-ui, "DejaVu Sans", sans-serif';
    c.lineCap = 'round';
    this.draw_axes(c, this.width - 58, 62, style);
    const px_per_m = this.height / (2 * Math.tan(this.camera.fov * Math.PI / 360) * this.far * this.size);
    let bar_m = Text.round_up(60 / px_per_m);
    const right = this.width - 24, y = this.height - (this.lifted ? 84 : 26);  // over the player
    c.strokeStyle = c.fillStyle = ink;
    c.lineWidth = 2;
    c.beginPath();
    c.moveTo(right - bar_m * px_per_m, y - 4);
    c.lineTo(right - bar_m * px_per_m, y);
    c.lineTo(right, y);
    c.lineTo(right, y - 4);
    c.stroke();
    c.textAlign = 'center';
    c.fillText(Number((1e3 * bar_m).toPrecision(3)) + ' mm', right - 0.5 * bar_m * px_per_m, y - 9);
  }

  draw_axes(c, x, y, style) {
    const axes = [['x', 1, 0, 0], ['y', 0, 1, 0], ['z', 0, 0, 1]].map(([name, ...along]) => {
      const v = new THREE.Vector3(...along).applyQuaternion(this.camera.quaternion.clone().inverse());
      return {name, color: style.getPropertyValue('--axis-' + name).trim(), v};
    }).sort((a, b) => a.v.z - b.v.z);
    for (const {name, color, v} of axes) {
      c.strokeStyle = c.fillStyle = color;
      c.globalAlpha = v.z < -0.2 ? 0.55 : 1;  // of the line alone: text is read
      c.lineWidth = 2.5;
      c.beginPath();
      c.moveTo(x, y);
      c.lineTo(x + 30 * v.x, y - 30 * v.y);
      c.stroke();
      c.globalAlpha = 1;
      c.textAlign = 'center';
      c.textBaseline = 'middle';
      c.fillText(name, x + 40 * v.x, y - 40 * v.y);
    }
    c.textBaseline = 'alphabetic';
  }

  // ---- picking ---------------------------------------------------------------------------------------------------------

  ray(x, y) {
    const at = new THREE.Vector3(2 * x / this.width - 1, 1 - 2 * y / this.height, 0.5).unproject(this.camera);
    const direction = at.sub(this.camera.position).normalize();
    return {origin: this.camera.position.toArray().map((v, a) => v * this.size + this.centre[a]), direction: direction.toArray()};
  }

  // The first patch of the rest shape under the pointer: {at_m, normal, touchable} or null.
  pick(x, y) {
    const {origin: o, direction: d} = this.into_body(this.ray(x, y)), r = this.rest;
    let best = null, nearest = Infinity;
    for (let q = 0; q < this.q; ++q) {
      const i = 3 * this.patch[3 * q], j = 3 * this.patch[3 * q + 1], k = 3 * this.patch[3 * q + 2];
      const ax = r[j] - r[i], ay = r[j + 1] - r[i + 1], az = r[j + 2] - r[i + 2];
      const bx = r[k] - r[i], by = r[k + 1] - r[i + 1], bz = r[k + 2] - r[i + 2];
      const px = d[1] * bz - d[2] * by, py = d[2] * bx - d[0] * bz, pz = d[0] * by - d[1] * bx;
      const det = ax * px + ay * py + az * pz;
      if (det <= 0) continue;  // seen from behind
      const sx = o[0] - r[i], sy = o[1] - r[i + 1], sz = o[2] - r[i + 2], u = (sx * px + sy * py + sz * pz) / det;
      if (u < 0 || u > 1) continue;
      const qx = sy * az - sz * ay, qy = sz * ax - sx * az, qz = sx * ay - sy * ax;
      const v = (d[0] * qx + d[1] * qy + d[2] * qz) / det, t = (bx * qx + by * qy + bz * qz) / det;
      if (v < 0 || u + v > 1 || t <= 0 || t >= nearest) continue;
      nearest = t;
      best = {q, alpha: [1 - u - v, u, v]};
    }
    if (!best) return null;
    const n = [0, 0, 0];
    for (let c = 0; c < 3; ++c) for (let a = 0; a < 3; ++a) n[a] += best.alpha[c] * this.rest_normal[9 * best.q + 3 * c + a];
    const length = Math.hypot(...n) || 1;
    const at_m = d.map((x_, a) => o[a] + nearest * x_), normal = n.map(x_ => x_ / length), touchable = (this.mark[best.q] & 1) === 1;
    if (!this.pose) return {at_m, normal, touchable};
    return {at_m: this.in_world(at_m), normal: new THREE.Vector3(...normal).applyQuaternion(this.pose.q).toArray(), touchable};
  }

  // A point of a body that has moved.
  in_world(x_m) {
    return this.pose ? new THREE.Vector3(...x_m).sub(this.pose.rest).applyQuaternion(this.pose.q).add(this.pose.centre).toArray() : x_m;
  }

  // A ray in the frame of a body that has moved.
  into_body({origin, direction}) {
    if (!this.pose) return {origin, direction};
    const {centre, rest, back} = this.pose;
    return {origin: new THREE.Vector3(...origin).sub(centre).applyQuaternion(back).add(rest).toArray(),
      direction: new THREE.Vector3(...direction).applyQuaternion(back).toArray()};
  }

  // Where the pointer's ray meets the plane through a point that faces the eye.
  on_plane(x, y, through_m) {
    const {origin, direction} = this.ray(x, y), away = new THREE.Vector3(0, 0, -1).applyQuaternion(this.camera.quaternion).toArray();
    const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const t = dot(through_m.map((v, a) => v - origin[a]), away) / dot(direction, away);
    return origin.map((v, a) => v + t * direction[a]);
  }

  // Where a point is on the stage, CSS pixels.
  project(x_m) {
    const p = this.scaled(x_m).project(this.camera);
    return [0.5 * (p.x + 1) * this.width, 0.5 * (1 - p.y) * this.height];
  }

  // The pixel that the last picture has there: [r, g, b, a], drawn anew as browsers keep none.
  pixel(x, y) {
    this.renderer.render(this.world, this.camera);
    const gl = this.renderer.getContext(), rgba = new Uint8Array(4);
    gl.readPixels(Math.round(x * this.ratio), Math.round((this.height - y) * this.ratio), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, rgba);
    return Array.from(rgba);
  }
}
