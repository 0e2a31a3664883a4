'use strict';
// The desk: state from the server, drawn here; every change goes there and comes back to all tabs.
const $ = (id) => document.getElementById(id);
const make = (tag, text, name) => { const one = document.createElement(tag); if (text !== undefined) one.textContent = text; if (name) one.className = name; return one; };
const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const shown = (value) => value === null || value === undefined ? '–' : Number(value.toPrecision(4)).toString();
let state = null, drawn = null, view = { from: null, to: null }, cursor = null, chosen = null, onCheck = false;

async function ask(message) {
  const answer = await fetch('ask', { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(message) });
  const text = await answer.text();
  const value = answer.headers.get('Content-Type') === 'application/json' ? JSON.parse(text) : { said: text };
  if (!answer.ok) throw new Error(value.said);
  return value;
}
function say(text, bad) { const note = $('note'); note.hidden = !text; note.textContent = text || ''; note.className = bad ? 'bad' : ''; }
const tried = (work) => work().catch((error) => say(error.message, true));

// One request for curves at a time: changes that come meanwhile are joined, and older ones dropped. What moves is drawn in
// wider bins, each with its least and largest sample; what rests, pixel by pixel.
let pending = new Map(), flying = false, stale = false, frames = 0, rest = 0;
function change(one) { const [kind] = Object.keys(one); pending.set(kind + one[kind].id, one); stale = true; fly(); }
function refresh() { stale = true; fly(); }
async function fly() {
  if (flying || !stale) return;
  flying = true; stale = false;
  const changes = [...pending.values()]; pending = new Map();
  const window_ = { from: view.from, to: view.to, pixels: Math.max(100, Math.round(($('charts').clientWidth - 60) / (changes.length ? 3 : 1))) };
  try {
    drawn = await ask(changes.length ? { ask: 'change', changes, window: window_, check: onCheck } : { ask: 'curves', window: window_, check: onCheck });
    // Of the record that is not drawn the gauge follows once the slider rests.
    state.gauges = { fit: drawn.gauges.fit ?? state.gauges.fit, check: drawn.gauges.check ?? state.gauges.check };
    if (changes.length) { say(''); clearTimeout(rest); rest = setTimeout(refresh, 150); }
    // What has changed meanwhile is not in them; work that runs counts up without changing the model.
    if (drawn.revision < state.revision && state.running === null) stale = true;
    soon();
  } catch (error) { say(error.message, true); }
  flying = false;
  // The next curves are worked out while these are drawn.
  fly();
}

function gauges() {
  const box = $('gauges'), { fit, check } = state.gauges;
  const all = [{ name: 'all sensors', fit: fit.all, check: check && check.all }, ...state.sensors.map((one, at) => ({ name: one.name, fit: fit.sensors[at], check: check && check.sensors[at] }))];
  box.replaceChildren(...all.map((one) => {
    const gauge = make('div', undefined, 'gauge'); gauge.append(make('b', one.name)); gauge.dataset.sensor = one.name;
    for (const [label, value] of [['fit', one.fit], ['check', one.check]]) {
      if (value === null || value === undefined) continue;
      const row = make('div', undefined, 'row'), meter = make('span', undefined, 'meter'), bar = make('i');
      // Ten times the noise in the middle, hundred at the end.
      bar.style.width = Math.min(100, 50 * Math.log10(1 + Math.max(0, value) * 0.99)) + '%'; bar.className = value > 1.3 ? 'off' : '';
      meter.append(bar); row.append(make('span', label), meter, make('output', shown(value) + ' ×')); gauge.append(row);
    }
    return gauge;
  }));
}

function surface(canvas) {
  const scale = window.devicePixelRatio || 1, { clientWidth: width, clientHeight: height } = canvas;
  if (canvas.width !== Math.round(width * scale) || canvas.height !== Math.round(height * scale)) { canvas.width = Math.round(width * scale); canvas.height = Math.round(height * scale); }
  const pen = canvas.getContext('2d'); pen.setTransform(scale, 0, 0, scale, 0, 0); pen.clearRect(0, 0, width, height); pen.font = '12px system-ui, sans-serif';
  return { pen, width, height };
}
function stairs() {
  const { pen, width, height } = surface($('stairs')), steps = state.staircase, left = 34, bottom = height - 18;
  const values = steps.flatMap((one) => [one.fit, one.check]).filter((one) => one !== null);
  const high = Math.log10(Math.max(2, ...values)) * 1.05, low = Math.min(0, Math.log10(Math.max(1e-3, Math.min(...values)))) - 0.05;
  const y = (value) => bottom - (Math.log10(Math.max(1e-3, value)) - low) / (high - low) * (bottom - 16), wide = (width - left - 6) / steps.length;
  pen.fillStyle = color('--soft'); pen.strokeStyle = color('--line'); pen.textAlign = 'right';
  for (const tick of [1, 10, 100, 1000].filter((tick) => Math.log10(tick) <= high)) { pen.beginPath(); pen.moveTo(left, y(tick)); pen.lineTo(width, y(tick)); pen.stroke(); pen.fillText(tick, left - 5, y(tick) + 4); }
  for (const [key, ink, dash] of [['fit', '--k0', []], ['check', '--k4', [5, 3]]]) {
    pen.strokeStyle = color(ink); pen.lineWidth = 2; pen.setLineDash(dash); pen.beginPath(); let last = null;
    steps.forEach((one, at) => { if (one[key] === null) return; const level = y(one[key]); if (last === null) pen.moveTo(left + at * wide, level); else pen.lineTo(left + at * wide, level); pen.lineTo(left + (at + 1) * wide, level); last = level; });
    pen.stroke(); pen.setLineDash([]);
    if (last !== null) { pen.fillStyle = color(ink); pen.textAlign = key === 'fit' ? 'left' : 'right'; pen.fillText(key, key === 'fit' ? left + 4 : width - 4, 11); }
  }
  pen.lineWidth = 1; pen.fillStyle = color('--soft'); pen.textAlign = 'center';
  steps.forEach((one, at) => { let label = one.label; while (label.length > 3 && pen.measureText(label).width > wide - 4) label = label.slice(0, -2) + '…'; pen.fillText(label, left + (at + 0.5) * wide, height - 4); });
  $('stairs').title = steps.map((one) => `${one.label}: fit ${shown(one.fit)}` + (one.check === null ? '' : `, check ${shown(one.check)}`)).join('\n');
}

const LEFT = 52, RIGHT = 8, SPLIT = 108;
const span = () => { const time = drawn.sensors[0].time; return [view.from ?? time[0], view.to ?? time[time.length - 1]]; };
function extent(lists, least) {
  let low = Infinity, high = -Infinity;
  for (const list of lists) for (const one of list) if (one !== null) { if (one < low) low = one; if (one > high) high = one; }
  if (!(low <= high)) return [-1, 1];
  const rim = Math.max((high - low) * 0.06, least); return [low - rim, high + rim];
}
function charts() {
  const box = $('charts');
  if (box.childElementCount !== state.sensors.length) box.replaceChildren(...state.sensors.map((one) => { const canvas = make('canvas'); canvas.setAttribute('role', 'img'); canvas.setAttribute('aria-label', `${one.name}: measured, model and misfit`); return canvas; }));
  // What is scrolled out of sight is drawn when it comes into view.
  state.sensors.forEach((sensor, at) => {
    const place = box.children[at].getBoundingClientRect();
    if (place.bottom > 0 && place.top < innerHeight) chart(box.children[at], sensor, drawn.sensors[at]);
  });
}
function ticks(low, high, most) {
  const raw = (high - low) / most, power = 10 ** Math.floor(Math.log10(raw)), step = [1, 2, 5, 10].map((one) => one * power).find((one) => one >= raw), all = [];
  for (let at = Math.ceil(low / step) * step; at <= high; at += step) all.push(Number(at.toPrecision(12)));
  return all;
}
// One number at an axis says nothing of its scale.
function enough(low, high, most) { const some = ticks(low, high, most); return some.length > 1 || most > 12 ? some : enough(low, high, most + 1); }
function chart(canvas, sensor, curves) {
  const { pen, width, height } = surface(canvas), [from, to] = span();
  const x = (time) => LEFT + (time - from) / (to - from) * (width - LEFT - RIGHT);
  const parts = [[20, SPLIT, extent([curves.measured, curves.model], sensor.noise), [['measured', '--k3', 2.6, 0.45], ['model', '--k2', 1.5, 1, [8, 3]]]], [SPLIT + 6, height - 16, extent([curves.misfit, [-3, 3]], 0.2), [['misfit', '--k2', 1.2, 1]]]];
  for (const [top, bottom, [low, high], lines] of parts) {
    const y = (value) => bottom - (value - low) / (high - low) * (bottom - top);
    pen.save(); pen.strokeStyle = color('--line'); pen.fillStyle = color('--soft'); pen.textAlign = 'right'; pen.lineWidth = 1;
    const unit = top < 30 ? '' : '×';
    for (const tick of enough(low, high, top < 30 ? 4 : 3)) { pen.beginPath(); pen.moveTo(LEFT, y(tick)); pen.lineTo(width - RIGHT, y(tick)); pen.stroke(); pen.fillText(tick + unit, LEFT - 5, y(tick) + 4); }
    pen.beginPath(); pen.rect(LEFT, top - 2, width - LEFT - RIGHT, bottom - top + 4); pen.clip(); pen.lineJoin = 'round';
    for (const [key, ink, thick, alpha, dash = []] of lines) {
      pen.strokeStyle = color(ink); pen.setLineDash(dash); pen.lineWidth = thick; pen.globalAlpha = alpha; pen.beginPath(); let open = false;
      curves[key].forEach((value, at) => { if (value === null) { open = false; return; } if (open) pen.lineTo(x(curves.time[at]), y(value)); else pen.moveTo(x(curves.time[at]), y(value)); open = true; });
      pen.stroke();
    }
    pen.restore();
  }
  pen.fillStyle = color('--soft'); pen.textAlign = 'center';
  for (const tick of ticks(from, to, Math.max(2, width / 110))) pen.fillText(`${tick} s`, Math.min(Math.max(x(tick), LEFT + 10), width - 18), height - 2);
  pen.textAlign = 'left'; pen.fillStyle = color('--ink'); pen.font = '600 12px system-ui, sans-serif'; let label = `${sensor.name}, ${sensor.unit}`;
  if (cursor !== null && cursor.time >= from && cursor.time <= to) {
    let at = curves.time.findIndex((time) => time >= cursor.time); if (at < 0) at = curves.time.length - 1;
    label += `   at ${shown(curves.time[at])} s: measured ${shown(curves.measured[at])}, model ${shown(curves.model[at])}, misfit ${shown(curves.misfit[at])} ×`;
    pen.strokeStyle = color('--ink'); pen.beginPath(); pen.moveTo(x(cursor.time), 18); pen.lineTo(x(cursor.time), height - 16); pen.stroke();
    if (cursor.begun !== undefined) { pen.fillStyle = color('--link'); pen.globalAlpha = 0.18; pen.fillRect(x(cursor.begun), 18, x(cursor.time) - x(cursor.begun), height - 34); pen.globalAlpha = 1; pen.fillStyle = color('--ink'); }
  }
  pen.fillText(label, LEFT, 12);
}
const timeAt = (event) => { const box = event.target.getBoundingClientRect(), [from, to] = span(); return from + Math.min(1, Math.max(0, (event.clientX - box.left - LEFT) / (box.width - LEFT - RIGHT))) * (to - from); };
let redraw = false, pictured = null;
const soon = () => {
  if (redraw) return;
  redraw = true;
  requestAnimationFrame(() => { redraw = false; gauges(); charts(); if (pictured !== drawn) { pictured = drawn; frames += 1; } });
};
$('charts').addEventListener('pointermove', (event) => { if (event.target.tagName === 'CANVAS' && drawn) { cursor = { ...cursor, time: timeAt(event) }; soon(); } });
$('charts').addEventListener('pointerleave', () => { cursor = null; if (drawn) soon(); });
$('charts').addEventListener('pointerdown', (event) => { if (event.target.tagName === 'CANVAS' && drawn && event.button === 0 && event.pointerType !== 'touch') cursor = { time: timeAt(event), begun: timeAt(event) }; });
addEventListener('pointerup', () => {
  if (!cursor || cursor.begun === undefined) return;
  const [a, b] = [cursor.begun, cursor.time].sort((a, b) => a - b), [from, to] = span(); cursor = { time: cursor.time };
  if (b - a > (to - from) / 100) zoom(a, b); else soon();
});
function zoom(from, to) { view = { from, to }; refresh(); }
const whole = () => zoom(null, null);
$('charts').addEventListener('dblclick', whole);
$('charts').addEventListener('keydown', (event) => {
  if (!drawn) return;
  const [from, to] = span(), wide = to - from, move = { ArrowLeft: [-0.2, -0.2], ArrowRight: [0.2, 0.2], '+': [0.2, -0.2], '-': [-0.3, 0.3] }[event.key];
  if (move) { zoom(from + move[0] * wide, to + move[1] * wide); event.preventDefault(); }
});
$('whole').onclick = whole;
$('which').onclick = () => { onCheck = !onCheck; $('which').textContent = onCheck ? 'show the fit record' : 'show the check record'; view = { from: null, to: null }; refresh(); };

function slider(one) {
  const box = make('div', undefined, 'slider'), track = make('div', undefined, 'track'), input = make('input'), output = make('output');
  Object.assign(input, { type: 'range', min: one.low, max: one.high, step: 'any' }); input.setAttribute('aria-label', one.id); input.dataset.id = one.id; box.dataset.slider = one.id;
  const label = make('span', one.name);
  input.oninput = () => { output.textContent = `${shown(Number(input.value))} ${one.unit}`; change({ value: { id: one.id, value: Number(input.value) } }); };
  track.append(input); box.append(label, output, track, make('small')); return box;
}
function card(one) {
  const box = make('div', undefined, 'card'), label = make('label', undefined, 'name'), on = make('input'); on.type = 'checkbox'; on.dataset.switch = one.id;
  on.onchange = () => change({ switch: { id: one.id, on: on.checked } });
  label.append(on, make('span', one.id)); box.append(label, make('p', one.meaning, 'soft'), ...one.sliders.map(slider)); box.dataset.card = one.id; return box;
}
function cards() {
  for (const [id, fault] of [['effects', false], ['faults', true]]) {
    const own = state.cards.filter((one) => one.fault === fault), key = JSON.stringify(own.map((one) => [one.id, one.sliders.map((slider) => [slider.id, slider.low, slider.high])])), box = $(id);
    if (box.dataset.key !== key) { box.dataset.key = key; box.replaceChildren(...(own.length ? own.map(card) : [make('p', fault ? 'The rig file names none.' : 'None in the model yet.', 'soft')])); }
  }
  for (const one of state.cards) {
    const box = document.querySelector(`[data-card="${CSS.escape(one.id)}"]`); box.classList.toggle('off', !one.on); box.querySelector('[data-switch]').checked = one.on;
    box.classList.toggle('lit', chosen !== null && ofPart(chosen, one.id));
    for (const own of one.sliders) {
      const row = box.querySelector(`[data-slider="${CSS.escape(own.id)}"]`), input = row.querySelector('input');
      if (!flying && !pending.size && input !== document.activeElement || input.value === '') input.value = own.value;
      if (input !== document.activeElement) row.querySelector('output').textContent = `${shown(own.value)} ${own.unit}`;
      let mark = row.querySelector('.interval');
      row.querySelector('small').textContent = own.known ?? 'not fitted';
      if (!own.interval) { if (mark) mark.remove(); continue; }
      if (!mark) { mark = make('i', undefined, 'interval'); row.querySelector('.track').append(mark); }
      const place = (value) => 100 * Math.min(1, Math.max(0, (value - own.low) / (own.high - own.low)));
      mark.style.left = place(own.interval[0]) + '%'; mark.style.width = place(own.interval[1]) - place(own.interval[0]) + '%';
    }
  }
}
const ofPart = (name, id) => { const part = state.parts.find((one) => one.name === name); return part !== undefined && (part.faults.includes(id) || part.effects.includes(id)); };

let circuitDrawn = '';
function circuit() {
  if (circuitDrawn === state.circuit) return;
  circuitDrawn = state.circuit; $('circuit').innerHTML = state.circuit;
  let symbol = null;
  // The name of a component follows its symbol.
  for (const one of $('circuit').querySelectorAll('svg > g, svg > text.name')) {
    if (one.tagName === 'g') { symbol = one; continue; }
    const part = state.parts.find((part) => part.name === one.textContent); if (!part || !symbol) continue;
    for (const target of [symbol, one]) { target.dataset.part = part.name; target.addEventListener('click', () => choose(part.name)); }
    one.setAttribute('tabindex', '0'); one.setAttribute('role', 'button'); one.addEventListener('keydown', (event) => { if (event.key === 'Enter') choose(part.name); });
  }
}
function choose(name) {
  chosen = name;
  for (const one of $('circuit').querySelectorAll('[data-part]')) one.classList.toggle('chosen', one.dataset.part === name);
  part(); cards();
}
function part() {
  const one = state.parts.find((part) => part.name === chosen); if (!one) return;
  const links = (title, names, act) => { const list = make('div', undefined, 'links'); list.append(...names.map((name) => { const button = make('button', name); button.type = 'button'; button.onclick = () => act(name); return button; })); return [make('h3', title), names.length ? list : make('p', 'none', 'soft')]; };
  const toCard = (name) => { const card = document.querySelector(`[data-card="${CSS.escape(name)}"]`); if (card) card.scrollIntoView({ behavior: 'smooth', block: 'center' }); };
  const toEffect = (name) => { if (state.cards.some((card) => card.id === name)) { toCard(name); return; } $('library').value = name; meaning(); $('add').scrollIntoView({ behavior: 'smooth', block: 'center' }); };
  const toChart = (name) => { const at = state.sensors.findIndex((sensor) => sensor.name === name); if ($('charts').children[at]) $('charts').children[at].scrollIntoView({ behavior: 'smooth', block: 'center' }); };
  $('part').replaceChildren(make('h3', one.name), make('p', one.meaning, 'soft'), ...links('Sensors', one.sensors, toChart), ...links('Faults', one.faults, toCard), ...links('Effects it may have', one.effects, toEffect));
}
function meaning() { const one = state.library.find((one) => one.id === $('library').value); $('meaning').textContent = one ? one.meaning : ''; }

// The curve that the record asks for, what it says, and a law of its form.
function rise(one) {
  const space = 'http://www.w3.org/2000/svg', svg = document.createElementNS(space, 'svg'), line = document.createElementNS(space, 'polyline'), [low, high] = extent([one.points.map((point) => point[1])], 0);
  const last = one.points[one.points.length - 1][0];
  svg.setAttribute('viewBox', '0 0 300 90'); svg.setAttribute('role', 'img'); svg.setAttribute('aria-label', one.sentence); svg.setAttribute('class', 'rise');
  line.setAttribute('points', one.points.map(([x, y]) => `${(x / last * 300).toFixed(1)},${(90 - (y - low) / (high - low) * 90).toFixed(1)}`).join(' ')); svg.append(line);
  const ends = make('p', `${shown(low)} to ${shown(high)} N, from 0 to ${shown(last)} mm`, 'soft');
  return [svg, ends, make('p', one.sentence), make('p', 'As a law, for the rig file:', 'soft'), make('pre', one.formula)];
}
function found() {
  const box = $('found'), one = state.found; box.hidden = !one; if (!one) return;
  const rows = one.candidates.map((candidate, number) => {
    const row = make('div', undefined, 'one'), head = make('div'), add = make('button', 'Add'); add.dataset.found = number; add.disabled = state.running !== null;
    add.onclick = () => tried(() => ask({ ask: 'add_found', number })); head.append(make('span', candidate.effect), add);
    const check = candidate.check_after === null ? '' : `; check ${shown(candidate.check_before)} → ${shown(candidate.check_after)}`;
    row.append(head, make('p', `${candidate.supported ? 'Supported' : 'Not supported'}: with the faults fitted along, error ${shown(candidate.before)} → ${shown(candidate.after)} times the noise${check}`, 'soft'), ...candidate.warnings.map((text) => make('p', text, 'soft')));
    return row;
  });
  box.replaceChildren(make('h2', 'What is missing'), make('p', one.headline), ...(one.place ? [make('p', one.place, 'soft')] : []), ...(one.rise ? rise(one.rise) : []), ...rows.slice(0, 6));
}
function judged() {
  const box = $('judged'), one = state.judged; box.hidden = !one; if (!one) return;
  const blocks = [one.fit, one.check].filter((comparison) => comparison).map((comparison, at) => {
    const block = make('div'), table = make('table'), head = make('tr'), faults = comparison.with_faults; block.dataset.judged = at ? 'check' : 'fit';
    head.append(...['sensor', 'model', ...(faults ? ['with faults'] : [])].map((text) => make('th', text)));
    const row = (name, alone, more) => { const row = make('tr'); row.append(make('td', name), make('td', shown(alone) + ' ×', 'number'), ...(faults ? [make('td', shown(more) + ' ×', 'number')] : [])); return row; };
    table.append(head, row('all sensors', comparison.times_noise, faults && faults.times_noise), ...comparison.channels.map((channel, at) => row(channel.name, channel.times_noise, faults && faults.channels[at].times_noise)));
    block.append(make('h3', at ? `Check record ${state.check}` : `Fit record ${state.fit}`), make('p', one.headlines[at]), table);
    if (faults) block.append(make('p', 'Faults found: ' + faults.faults.map((fault) => `${fault.id} ${shown(fault.value)} ${fault.unit}`).join(', '), 'soft'));
    return block;
  });
  box.replaceChildren(make('h2', 'As borescope compare says'), make('p', 'Times the sensor noise; of the rig file as it would be saved now.', 'soft'), ...blocks);
}

function show() {
  $('rig').textContent = state.rig || state.file; document.title = `${state.rig || state.file} – desk`;
  $('files').textContent = `${state.file}; fit ${state.fit}` + (state.check ? `; check ${state.check}` : '');
  $('which').hidden = !state.check; $('judge').textContent = state.check ? 'Judge on the check record' : 'Judge';
  const running = state.running; $('work').hidden = !running;
  for (const id of ['find', 'fit', 'judge']) $(id).disabled = running !== null;
  $('undo').disabled = running !== null || !state.can_undo;
  for (const button of document.querySelectorAll('#add button, #save button')) button.disabled = running !== null;
  if (running) { $('stage').textContent = running.stage + (running.of ? `: ${running.done} of ${running.of}` : ' …'); const bar = $('progress'); if (running.of) { bar.max = running.of; bar.value = running.done; } else bar.removeAttribute('value'); }
  if (state.note) say(state.note.text, state.note.bad); else if (running) say('');
  gauges(); stairs(); circuit(); cards(); found(); judged();
  const key = state.library.map((one) => one.id).join(' '), select = $('library');
  if (select.dataset.key !== key) { const before = select.value; select.dataset.key = key; select.replaceChildren(...state.library.map((one) => { const option = make('option', one.id); option.value = one.id; return option; })); if (state.library.some((one) => one.id === before)) select.value = before; meaning(); }
}
async function listen() {
  for (;;) {
    try {
      const answer = await fetch('state' + (state ? `?since=${state.revision}` : ''));
      if (!answer.ok) throw new Error(await answer.text());
      const news = await answer.json(), other = !drawn || news.revision !== state.revision && news.revision !== drawn.revision;
      state = news; show();
      if (other && !flying) refresh();
    } catch (error) { say('The desk does not answer any more: it was ended. ' + error.message, true); await new Promise((then) => setTimeout(then, 2000)); }
    // A slider that moves has better things to wait for.
    await new Promise((then) => setTimeout(then, flying || stale ? 500 : 60));
  }
}
for (const task of ['find', 'fit', 'judge']) $(task).onclick = () => tried(() => ask({ ask: 'begin', task }));
$('stop').onclick = () => tried(() => ask({ ask: 'stop' }));
$('undo').onclick = () => tried(() => ask({ ask: 'undo' }));
$('library').onchange = meaning;
$('add').onsubmit = (event) => { event.preventDefault(); tried(() => ask({ ask: 'add', effect: $('library').value })); };
$('save').onsubmit = (event) => {
  event.preventDefault(); const name = $('name').value.trim();
  tried(async () => {
    try { await ask({ ask: 'save', name, replace: false }); } catch (error) {
      if (!error.message.includes('would be overwritten') || error.message.includes('is read') || !confirm(`${error.message}\n\nReplace ${name}?`)) throw error;
      await ask({ ask: 'save', name, replace: true });
    }
  });
};
addEventListener('scroll', () => { if (drawn) soon(); }, { capture: true, passive: true });
addEventListener('resize', () => { if (state) { stairs(); refresh(); } });
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { if (drawn) { charts(); stairs(); } });
listen();
