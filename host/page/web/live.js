// SPDX-License-Identifier: MIT
// The page over a real session: what the servo answers comes by a WebSocket from the program that serves the page, and
// the pointer, where it is this page's, goes there. Stands where the engine stands, in front of it.
class Live {
  // told: called when what is known of the session changes.
  // bytes: of a tick, all its fingers, how far the body has swung and where it is.
  constructor(engine, bytes, told) {
    Object.assign(this, {engine, bytes, told, yours: false, lost: 0, ticks: 0, trouble: 'Connecting …', goals: [null, null], held: 0, hand: null});
    const base = location.href.replace(/[?#].*$/, '').replace(/^http/, 'ws');
    this.socket = new WebSocket(base + (base.endsWith('/') ? '' : '/') + 'session');
    this.socket.binaryType = 'arraybuffer';
    this.socket.onmessage = event => typeof event.data === 'string' ? this.hear(JSON.parse(event.data)) : this.feed(event.data);
    this.socket.onclose = () => this.end();
  }

  feed(ticks) {
    this.ticks += ticks.byteLength / this.bytes;
    this.engine.postMessage({kind: 'feed', ticks});
  }

  hear(status) {
    const begins = status.yours && !this.yours;
    Object.assign(this, {touch: status.touch, yours: status.yours, lost: status.lost, trouble: status.trouble});
    if (begins && this.hand) this.say(this.hand);
    this.told();
  }

  end() {
    Object.assign(this, {yours: false, goals: [null, null], trouble: 'The program that serves this page has ended, or has let it go: start it again, and open the address that it prints.'});
    this.told();
  }

  say(message) {
    if (this.yours && this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  // What an engine is asked, and who answers it here.
  postMessage(message) {
    if (message.kind === 'mode' || message.kind === 'anew') return;
    if (message.kind === 'hand') this.hand = message;
    if (message.kind === 'goal' && this.yours) this.goals[message.finger] = message.at;
    if (message.kind === 'goal' || message.kind === 'hand') return this.say(message);
    this.engine.postMessage(message);
  }

  // Bits of a device's buttons, down or up.
  press(button, down) {
    const held = down ? this.held | button : this.held & ~button;
    if (held === this.held) return;
    this.held = held;
    this.say({kind: 'buttons', held});
  }

  // A line for people.
  get text() {
    if (this.trouble) return this.trouble;
    const role = this.yours ? 'your pointer is the device' : this.touch ? 'another page has the pointer: this one looks' : 'this page only looks';
    return 'live · ' + role + (this.lost > 0 ? ' · ' + Text.count(this.lost) + ' ticks not heard' : '');
  }
}
