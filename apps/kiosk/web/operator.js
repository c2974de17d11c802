// SPDX-License-Identifier: Apache-2.0
// The operator's part: records one person with what a tape says, and has the sessions there are. docs/page.md names
// what it asks for below /operator/.
'use strict';

const at = (id) => document.getElementById(id);
const kPollMs = 500;
const kReplayMs = 100;
const kStayMs = 60000;  // how often touches are reported: a session ends half an hour after the last
const kLowPercent = 50;  // a joint that is as likely wrong as right
const kEdges = ['x0', 'z0', 'x1', 'z1'];  // as --region has them
const kReachMaxM = 20;
const kPlanHalfM = 3, kPlanFarM = 6;  // as floor_plan.h
const kPlanStepM = 0.05, kPlanLeastM = 0.1;  // drawn edges lie at such steps; less is no rectangle
const kFormFields = ['person', 'height', 'weight', 'age', 'gender', 'worn_size', 'clothing', 'notes'];

const words = new Words(new URLSearchParams(location.search).get('lang') || navigator.language || 'en');
const mirror = new Mirror(at('sight'));
const failures = [];
for (const kind of ['error', 'unhandledrejection']) {
  window.addEventListener(kind, (e) => failures.push(String(e.message || e.reason)));
}
let token = '', form = {tape: []}, state = {phase: 'IDLE', ready: false}, said = '', jobSeen = '', unreached = '', erased = '';
let joints = [], confidence = null, replaying = 0, regionShown = null, planSeen = '', planPicture = null, planCorner = null;

// "list.title" of the operator's texts.
const of = (key) => key.split('.').reduce((table, word) => table && table[word], words.table.operator);

// --- asking
async function get(path) {
  const answer = await fetch(path);
  if (answer.status === 401) signedOut();
  if (!answer.ok) throw new Error((await answer.text()).trim());
  return answer;
}
async function ask(path, body) {
  const headers = {'Content-Type': 'application/json', 'X-Im2fit-Token': token};
  const answer = await fetch(path, {method: 'POST', headers, body: JSON.stringify(body)});
  if (answer.status === 401) signedOut();
  if (!answer.ok) throw new Error((await answer.text()).trim());
}
// What goes wrong is said; a fault of the network, too.
async function tried(work) {
  try {
    at('trouble').textContent = '';
    await work();
  } catch (error) {
    at('trouble').textContent = error.message;
  }
  await poll();
}

// --- texts
function showTexts() {
  if (!words.table) return;
  document.documentElement.lang = words.language;
  for (const e of document.querySelectorAll('[data-text]')) e.textContent = of(e.dataset.text);
  at('points').replaceChildren(...[...of('consent.points'), ...words.shopPoints(form.shop)].map((text) => {
    const item = document.createElement('li');
    item.textContent = text;
    return item;
  }));
  for (const id of ['sight', 'replayed']) at(id).setAttribute('aria-label', of('misc.sight'));
  at('plan').setAttribute('aria-label', of('region.plan'));
  drawPlan();
  at('languages').setAttribute('aria-label', words.of('languages'));
  at('comparison-name').textContent = words.of('name-head');
  for (const button of at('languages').children) {
    button.setAttribute('aria-current', String(button.lang === words.language));
  }
  showConfidence(confidence);
  showTape();
  showState();
  showSessions();
  showStatistics();
}
const nameOf = (entry) => entry.names[words.language] || entry.names.en || entry.id;
function showTape() {
  const blank = document.createElement('option');
  blank.value = blank.textContent = '';
  const taken = new Set([...at('readings').children].map((row) => row.dataset.id));
  at('add').replaceChildren(blank, ...form.tape.filter((entry) => !taken.has(entry.id)).map((entry) => {
    const option = document.createElement('option');
    option.value = entry.id;
    option.textContent = nameOf(entry);
    return option;
  }));
  for (const row of at('readings').children) {
    const name = nameOf(form.tape.find((entry) => entry.id === row.dataset.id));
    const [title, first, second, remove] = row.children;
    title.textContent = name;
    first.setAttribute('aria-label', `${name}, ${of('form.first')}`);
    second.setAttribute('aria-label', `${name}, ${of('form.second')}`);
    first.placeholder = of('form.first');
    second.placeholder = of('form.second');
    remove.setAttribute('aria-label', `${of('form.remove')}: ${name}`);
  }
}
function addReading(id) {
  const row = document.createElement('div');
  row.className = 'reading';
  row.dataset.id = id;
  const inputs = [0, 1].map(() => {
    const input = document.createElement('input');
    input.inputMode = 'decimal';
    return input;
  });
  const remove = document.createElement('button');
  remove.type = 'button';
  remove.textContent = '×';
  remove.addEventListener('click', () => {
    row.remove();
    showTape();
  });
  row.append(document.createElement('span'), ...inputs, remove);
  at('readings').append(row);
  showTape();
  inputs[0].focus();
}

// --- the form as the truth of a session; decimal commas are read, nothing else is guessed
function number(input, factor) {
  const text = input.value.trim().replace(',', '.');
  if (!text) return undefined;
  const value = Number(text);
  if (!Number.isFinite(value)) {
    input.focus();
    throw new Error(`${input.labels && input.labels[0] ? input.labels[0].innerText : input.ariaLabel}: ${input.value}`);
  }
  return Math.round(value * factor * 10) / 10;
}
function truth() {
  const found = {
    height_mm: number(at('height'), 10), weight_kg: number(at('weight'), 1), age_years: number(at('age'), 1),
    gender: at('gender').value || undefined, worn_size: at('worn_size').value.trim() || undefined,
    clothing: at('clothing').value || undefined, tape: {},
  };
  for (const row of at('readings').children) {
    const values = [row.children[1], row.children[2]].map((input) => number(input, 10));
    const given = values.filter((v) => v !== undefined);
    if (given.length) found.tape[row.dataset.id] = given;
  }
  return found;
}
function clearForm() {
  for (const id of kFormFields) at(id).value = '';
  at('readings').replaceChildren();
  showTape();
}

// --- where to measure: the text of --region from four fields, in metres; "" of four empty ones
function regionText() {
  const values = ofFields();
  if (values.every((text) => !text)) return '';
  const fault = (id, key) => {
    at(id).focus();
    const field = at(id).labels[0].innerText.trim();
    throw new Error(of(`region.${key}`).replace('{field}', field).replace('{text}', at(id).value));
  };
  kEdges.forEach((id, i) => { if (!values[i]) fault(id, 'missing'); });
  kEdges.forEach((id, i) => { if (!/^-?(\d+\.?\d*|\.\d+)$/.test(values[i])) fault(id, 'not_number'); });
  kEdges.forEach((id, i) => { if (Math.abs(Number(values[i])) > kReachMaxM) fault(id, 'too_far'); });
  const [x0, z0, x1, z1] = values.map(Number);
  if (x0 >= x1) fault('x0', 'order_x');
  if (z0 >= z1) fault('z0', 'order_z');
  return [x0, z0, x1, z1].join(',');
}
const edgeText = (metres) => words.number(metres, 3).replace(/[.,]?0+$/, '').replace(/^-0$/, '0');

// --- the floor from above, camera at the bottom: the rectangle of the fields, which a drag fills in
const ofFields = () => kEdges.map((id) => at(id).value.trim().replace(',', '.').replace('\u2212', '-'));
function drawPlan() {
  const canvas = at('plan'), context = canvas.getContext('2d');
  const scale = canvas.width / (2 * kPlanHalfM);
  const across = (x) => (x + kPlanHalfM) * scale, down = (z) => canvas.height - z * scale;
  context.clearRect(0, 0, canvas.width, canvas.height);
  context.imageSmoothingEnabled = false;
  if (planPicture) context.drawImage(planPicture, 0, 0, canvas.width, canvas.height);
  context.font = '24px sans-serif';
  context.strokeStyle = '#ffffff40';
  context.lineWidth = 1;
  context.fillStyle = '#ffffff';
  for (let m = 1 - kPlanHalfM; m < kPlanHalfM; ++m) {
    context.strokeRect(across(m), -9, 0, canvas.height + 18);
    if (m !== 0) context.fillText(words.number(m, 0), across(m) + 5, canvas.height - 6);  // the camera is there
  }
  for (let m = 1; m < kPlanFarM; ++m) {
    context.strokeRect(-9, down(m), canvas.width + 18, 0);
    context.fillText(`${words.number(m, 0)} m`, 6, down(m) - 5);
  }
  context.beginPath();  // the camera
  for (const [x, z] of [[0, 0.22], [-0.14, 0], [0.14, 0]]) context.lineTo(across(x), down(z));
  context.fill();
  const values = ofFields();
  if (values.some((text) => !/^-?(\d+\.?\d*|\.\d+)$/.test(text))) return;
  const [x0, z0, x1, z1] = values.map(Number);
  if (x0 >= x1 || z0 >= z1) return;
  context.fillStyle = '#8fd0e640';
  context.fillRect(across(x0), down(z1), (x1 - x0) * scale, (z1 - z0) * scale);
  context.strokeStyle = '#8fd0e6';
  context.lineWidth = 5;
  context.strokeRect(across(x0), down(z1), (x1 - x0) * scale, (z1 - z0) * scale);
}
async function showPlan() {
  const key = token && state.plan ? state.plan.join() : '';
  if (key === planSeen) return;
  planSeen = key;
  let picture = null;
  try {
    if (key) picture = await createImageBitmap(await (await get('/operator/plan')).blob());
  } catch (error) {  // cut off, or no picture: the next poll asks again
  }
  if (key !== planSeen) return;  // a later one, or signed out
  if (!picture) planSeen = '';
  planPicture = picture;
  document.body.dataset.plan = picture ? key : '';
  drawPlan();
}
const mayDraw = () => Boolean(token && state.region) && !state.region.fixed && !at('region-set').disabled;
function onPlan(event) {
  const box = at('plan').getBoundingClientRect();
  const stepped = (m, least, most) => Math.round(Math.min(Math.max(m, least), most) / kPlanStepM) * kPlanStepM;
  return [stepped(((event.clientX - box.left) / box.width - 0.5) * 2 * kPlanHalfM, -kPlanHalfM, kPlanHalfM),
    stepped((1 - (event.clientY - box.top) / box.height) * kPlanFarM, 0, kPlanFarM)];
}
at('plan').addEventListener('pointerdown', (event) => {
  if (!mayDraw() || !event.isPrimary || event.button !== 0) return;
  planCorner = onPlan(event);
  at('plan').setPointerCapture(event.pointerId);
  event.preventDefault();
});
at('plan').addEventListener('pointermove', (event) => {
  if (!planCorner || !event.isPrimary) return;
  const [x, z] = onPlan(event), [cornerX, cornerZ] = planCorner;
  if (Math.abs(x - cornerX) < kPlanLeastM - 1e-9 || Math.abs(z - cornerZ) < kPlanLeastM - 1e-9) return;
  const drawn = [Math.min(x, cornerX), Math.min(z, cornerZ), Math.max(x, cornerX), Math.max(z, cornerZ)];
  kEdges.forEach((id, i) => { at(id).value = edgeText(drawn[i]); });
  at('region-fault').textContent = '';
  drawPlan();
});
for (const kind of ['pointerup', 'pointercancel']) at('plan').addEventListener(kind, () => { planCorner = null; });
for (const id of kEdges) at(id).addEventListener('input', drawPlan);

// What holds; fields that the operator is filling in keep what they have.
function showRegion() {
  const region = state.region;
  if (!region) return;
  if (regionShown !== region.text) {
    regionShown = region.text;
    const values = region.text ? region.text.split(',') : ['', '', '', ''];
    kEdges.forEach((id, i) => { at(id).value = values[i] && edgeText(Number(values[i])); });
    drawPlan();
  }
  for (const id of kEdges) at(id).readOnly = region.fixed;
  at('region-set').hidden = region.fixed;
  at('region-set').disabled = ['WAITING', 'RECORDING'].includes(document.body.dataset.phase);
  at('plan').classList.toggle('fixed', !mayDraw());
  const help = of(`region.${region.fixed ? 'plan_fixed' : state.plan ? 'draw' : 'no_plan'}`);
  if (at('plan-help').textContent !== help) at('plan-help').textContent = help;
  const lines = [region.text ? of('region.held') : of('region.everywhere')];
  if (region.fixed) lines.push(of('region.fixed'));
  if (region.error) lines.push(region.error);
  const text = lines.join(' ');
  if (at('region-now').textContent !== text) at('region-now').textContent = text;
}
// Why no person is seen, with the option that mends it.
function showDiagnosis() {
  const found = state.diagnosis;
  at('diagnosis').hidden = !found;
  if (!found) return;
  const key = found.code === 'UNIT' && !(found.unit_mm > 0) ? 'UNIT_UNKNOWN' : found.code;
  const unit = String(Number(Number(found.unit_mm).toPrecision(3)));
  const text = (of(`diagnosis.${key}`) || found.text).replace('{unit}', unit).replace('{deg}', found.rotate_deg);
  if (at('diagnosis-text').textContent !== text) at('diagnosis-text').textContent = text;
}

// --- what the program says
function showState() {
  if (!words.table) return;
  const phase = !token ? 'SIGNED_OUT' : state.ready ? state.phase : 'WAITING';
  const recording = state.recording || {frames: 0, frames_max: 0, dropped: 0};
  document.body.dataset.phase = phase;
  if (!token) return;
  const lines = [of(`phases.${phase}`).replace('{n}', recording.frames).replace('{max}', recording.frames_max)];
  if (recording.full && phase === 'RECORDING') lines.push(of('misc.full'));
  if (recording.dropped) lines.push(of('misc.dropped').replace('{n}', recording.dropped));
  if (recording.error) lines.push(recording.error);
  if (state.job && state.job.running) lines.push(of('misc.working'));
  if (state.erased) lines.push(of('misc.erased').replace('{id}', state.erased));
  else if (said) lines.push(of('misc.saved').replace('{id}', said));
  const text = lines.join(' · ');
  if (at('status').textContent !== text) at('status').textContent = text;
  const busy = Boolean(state.job && state.job.running);
  at('begin').disabled = phase !== 'IDLE' || busy;
  at('save').disabled = phase !== 'MEASURED' || busy;
  at('discard').disabled = !['RECORDING', 'MEASURED'].includes(phase) || busy;
  showRegion();
  showDiagnosis();
}
function jobDone(job) {
  if (job.error) at('trouble').textContent = job.error;
  if (job.kind === 'save' && !job.error) {
    said = job.id;
    clearForm();
  }
  if (job.kind === 'measure' && job.result) showComparison(job.result);
  loadSessions();
}
async function poll() {
  if (!token) return;
  try {
    state = await (await get('/operator/state')).json();
    if (unreached) at('trouble').textContent = unreached = '';
  } catch (error) {  // what was there stays: the form and the recording may go on
    if (token) at('trouble').textContent = unreached = words.say('SERVER_GONE');
    return;
  }
  const key = state.job ? JSON.stringify([state.job.kind, state.job.id, state.job.error, state.job.running]) : '';
  if (key !== jobSeen && state.job && !state.job.running) jobDone(state.job);
  jobSeen = key;
  if (state.erased && state.erased !== erased) loadSessions();
  erased = state.erased;
  showState();
  showPlan();
}

// --- sessions
let sessions = [];
async function loadSessions() {
  try {
    sessions = await (await get('/operator/sessions')).json();
  } catch (error) {
    return;
  }
  showSessions();
}
function button(text, work) {
  const made = document.createElement('button');
  made.type = 'button';
  made.textContent = text;
  made.addEventListener('click', () => work(made));
  return made;
}
function showSessions() {
  if (!words.table) return;
  at('none').hidden = sessions.length > 0;
  at('list').replaceChildren(...sessions.map((one) => {
    const item = document.createElement('li');
    item.dataset.id = one.id;
    const text = document.createElement('span');
    text.textContent = one.damage ? one.damage : [one.person, one.started_utc.replace('T', ' ').replace('Z', ' UTC'),
      of('list.values').replace('{n}', one.tape_values)].join(' · ');
    item.append(text);
    if (!one.damage) {
      item.append(button(of('list.measure'), () => tried(() => ask('/operator/measure', {id: one.id}))));
      item.append(button(of('list.replay'), () => replay(one.id)));
    }
    item.append(button(of('list.delete'), (made) => {
      if (!made.dataset.sure) {  // the second press means it
        made.dataset.sure = 'true';
        made.textContent = of('list.sure');
        return;
      }
      tried(() => ask('/operator/delete', {id: one.id})).then(loadSessions);
    }));
    return item;
  }));
}
function showComparison(result) {
  const rows = Object.entries(result.now.measurements || {}).map(([id, now]) => {
    const then = ((result.then || {}).measurements || {})[id];
    const row = document.createElement('tr');
    const name = document.createElement('th');
    name.scope = 'row';
    name.textContent = `${words.name(id)}, ${words.unit(now.unit)}`;
    row.append(name);
    const known = then && then.value !== null && now.value !== null;
    for (const text of [then ? words.value(then.value, now.unit) : '–', words.value(now.value, now.unit),
      known ? words.value(now.value - then.value, now.unit).replace(/^-(0[.,]?0*)$/, '$1') : '–']) row.insertCell().textContent = text;
    return row;
  });
  at('comparison').tBodies[0].replaceChildren(...rows);
  at('comparison').hidden = rows.length === 0;
}
// Pictures of the recording one after the other, until there is none.
async function replay(id) {
  const mine = ++replaying;
  at('again').hidden = false;
  const shown = new Mirror(at('replayed'));
  for (let frame = 0; mine === replaying; frame += 3) {
    const answer = await fetch(`/operator/picture?id=${id}&number=${frame}`).catch(() => null);
    if (!answer || !answer.ok) break;
    shown.picture = await createImageBitmap(await answer.blob());
    shown.picture.naturalWidth = shown.picture.width;
    shown.picture.naturalHeight = shown.picture.height;
    shown.draw();
    document.body.dataset.replayed = frame;
    await new Promise((done) => setTimeout(done, kReplayMs));
  }
}

// --- statistics: counts of all people together; a day's visits, a month's sizes and reasons
const kDaysShown = 14, kStatisticsMs = 10000;
let statistics = null;  // rows of period, what, name, count; null: nothing is counted
async function loadStatistics() {
  if (!token) return;
  if (!form.counts) return showStatistics();
  try {
    const lines = (await (await get('/operator/statistics.csv')).text()).trim().split('\n').slice(1);
    statistics = lines.map((line) => line.split(','));
  } catch (error) {
    return;
  }
  showStatistics();
}
function showStatistics() {
  if (!words.table) return;
  const rows = statistics || [], month = rows.map(([period]) => period.slice(0, 7)).sort().pop() || '';
  at('statistics-note').textContent = !form.counts ? of('statistics.off') : rows.length ? '' : of('statistics.none');
  at('export').hidden = !form.counts;
  const reason = (code) => (code === 'LEFT' ? of('statistics.left') : words.say(code) || code);
  for (const [id, key, what, name] of [['statistics-sizes', 'sizes', 'size', (size) => size],
    ['statistics-reasons', 'reasons', 'not_measured', reason]]) {
    const found = rows.filter((row) => row[0] === month && row[1] === what).sort((a, b) => b[3] - a[3]);
    const list = found.map((row) => `${name(row[2])} ${words.number(Number(row[3]), 0)}`).join(' · ');
    at(id).textContent = list ? of(`statistics.${key}`).replace('{month}', month).replace('{list}', () => list) : '';
  }
  const days = [...new Set(rows.filter((row) => row[1] === 'visits').map((row) => row[0]))].sort().reverse();
  at('days').hidden = days.length === 0;
  at('days').tBodies[0].replaceChildren(...days.slice(0, kDaysShown).map((day) => {
    const line = document.createElement('tr'), head = document.createElement('th');
    head.scope = 'row';
    head.textContent = day;
    line.append(head);
    for (const what of ['visits', 'measured']) {
      const row = rows.find((one) => one[0] === day && one[1] === what);
      line.insertCell().textContent = words.number(row ? Number(row[3]) : 0, 0);
    }
    return line;
  }));
}
setInterval(loadStatistics, kStatisticsMs);

// --- live depth and joints, from the stream all pages have
function showConfidence(percent) {
  confidence = percent;
  at('joints').tBodies[0].replaceChildren(...joints.map((name, i) => {
    const row = document.createElement('tr');
    const head = document.createElement('th');
    head.scope = 'row';
    head.textContent = words.table ? of(`joints.${name}`) : name;
    row.append(head);
    const cell = row.insertCell();
    cell.textContent = percent ? `${percent[i]} %` : '–';
    cell.classList.toggle('low', Boolean(percent) && percent[i] < kLowPercent);
    return row;
  }));
}
const stream = new EventSource('/events');
let drawnAt = 0;
stream.onmessage = (message) => {
  const event = JSON.parse(message.data);
  if (event.event === 'hello') {
    joints = event.joints;
    mirror.setBones(event.bones, event.joints);
    showConfidence(null);
  }
  if (event.event === 'picture') mirror.load(event.number);
  if (event.event === 'visit' && event.state === 'ASKING') {
    mirror.clear();
    showConfidence(null);
  }
  if (event.event !== 'frame' || Date.now() - drawnAt < 100) return;
  drawnAt = Date.now();
  mirror.setJoints(event.pixels, '');
  showConfidence(event.confidence);
};

// --- what the operator does
at('begin').addEventListener('click', () => tried(async () => {
  said = '';
  await ask('/operator/begin', {language: words.language, version: words.consentVersion(of('consent.version'), form.shop)});
}));
at('discard').addEventListener('click', () => tried(() => ask('/operator/discard', {})));
at('form').addEventListener('submit', (event) => {
  event.preventDefault();
  tried(() => ask('/operator/save', {
    person: at('person').value.trim(), site: at('site').value.trim(), notes: at('notes').value, truth: truth(),
  }));
});
at('region').addEventListener('submit', (event) => {
  event.preventDefault();
  at('region-fault').textContent = '';
  let text = '';
  try {
    text = regionText();
  } catch (error) {
    at('region-fault').textContent = error.message;
    return;
  }
  tried(() => ask('/operator/region', {region: text}));
});
at('add').addEventListener('change', () => {
  if (at('add').value) addReading(at('add').value);
});

// --- signing in and out. The session is a cookie that scripts cannot read; half an hour without a touch ends it.
function signedOut() {
  token = said = jobSeen = '';
  regionShown = planCorner = planPicture = null;
  planSeen = '';
  ++replaying;  // ends a replay
  sessions = [];
  statistics = null;
  state = {phase: 'IDLE', ready: false};
  clearForm();
  at('again').hidden = at('comparison').hidden = true;
  at('comparison').tBodies[0].replaceChildren();
  showTexts();
}
async function enter() {
  token = await (await get('/operator/token')).text();
  form = await (await get('/operator/form')).json();
  at('site').value = form.site;
  at('trouble').textContent = '';
  showTexts();
  await loadSessions();
  await loadStatistics();
  await poll();
}
at('sign-in').addEventListener('submit', async (event) => {
  event.preventDefault();
  at('trouble').textContent = '';
  at('enter').disabled = true;
  try {
    const answer = await fetch('/operator/sign-in', {method: 'POST', headers: {'Content-Type': 'application/json'},
      body: JSON.stringify({password: at('password').value})});
    if (answer.ok) await enter();
    else at('trouble').textContent = answer.status === 403 ? of('sign_in.wrong') : (await answer.text()).trim();
  } catch (error) {
    at('trouble').textContent = words.say('SERVER_GONE');
  }
  at('enter').disabled = false;
  at('password').value = '';
});
at('sign-out').addEventListener('click', () => tried(async () => {
  await ask('/operator/sign-out', {});
  signedOut();
  at('password').focus();
}));
let stayedAt = Date.now();
for (const kind of ['pointerdown', 'keydown', 'click']) {
  window.addEventListener(kind, () => {
    if (!token || Date.now() - stayedAt < kStayMs) return;
    stayedAt = Date.now();
    get('/operator/token').catch(() => null);
  });
}

async function start() {
  await words.load();
  at('languages').replaceChildren(...kLanguages.map((language) => {
    const made = button(words.tables[language].name, () => {
      words.language = language;
      showTexts();
    });
    made.lang = language;
    return made;
  }));
  showTexts();
  try {
    await enter();
  } catch (error) {  // nobody is signed in
    at('password').focus();
  }
  setInterval(poll, kPollMs);
}
start();
