// SPDX-License-Identifier: Apache-2.0
// What the program publishes at /events, shown. Its events are those of docs/result.md and docs/page.md. All that is
// on the screen belongs to one visit; with another, or without the program, it goes.
'use strict';

const at = (id) => document.getElementById(id);
const kQuietMs = 3000;    // the program sends something every second
const kTouchMs = 2000;    // touches are reported no more often
const kReconnectMs = 1000;
const kRed = ['NO_CAMERA', 'MODELS_MISSING', 'SERVER_GONE', 'TOO_MANY_SCREENS'];
const kAmber = ['CAMERA_LOST', 'OVER'];
const kNothingSeen = {state: 'SEARCHING', guidance: [], details: {}, used: 0, back: 0, turned: null};

const words = new Words(new URLSearchParams(location.search).get('lang') || navigator.language || 'en');
const sounds = new Sounds();
const facts = new Facts(at('facts'), at('told'));
document.addEventListener('im2fit-result', (event) => {
  facts.measured(event.detail);
  showPanel();
});
document.addEventListener('im2fit-forget', () => facts.forget());
const mirror = new Mirror(at('sight'));
const failures = [];  // what went wrong here, for who looks into it
for (const kind of ['error', 'unhandledrejection']) {
  window.addEventListener(kind, (e) => failures.push(String(e.message || e.reason)));
}
let boot = null, hello = {asks: true, keeps_files: false, frames_wanted: 30, segments: []};
let visit = null;         // {id, state}
let seen = {...kNothingSeen};
let result = null;
let link = 'SERVER_GONE';  // or 'TOO_MANY_SCREENS', or '' while events come
let trouble = '', camera = '', over = false;
let offer = null, offerTimer = 0;  // what /hand-over answered
let panel = 'tryon';               // beside the body: 'tryon', 'phone' or 'figures'
let stage = null;
try {
  stage = new Stage(at('canvas'));
} catch (error) {
  document.body.dataset.flat = 'true';  // this browser shows no 3D (WebGL)
}

function codeNow() {
  if (link) return link;
  if (trouble) return trouble;
  if (camera) return camera;
  if (!visit || visit.state === 'ASKING') return over ? 'OVER' : 'WELCOME';
  if (visit.state === 'RESULT') return facts.open ? 'FACTS' : 'DONE';
  if (visit.state === 'FACTS' && !over) return 'FACTS';
  return over ? 'OVER' : codeFor(seen.state, seen.guidance, seen.details);
}
function stageFor(code) {
  if (link || !visit) return 'trouble';
  if (visit.state === 'RESULT' && !facts.open) return result ? 'result' : 'trouble';
  if (kRed.includes(code) || kAmber.includes(code)) return 'trouble';
  if (code === 'FACTS') return 'facts';
  return visit.state === 'ASKING' ? 'welcome' : 'measure';
}
function toneFor(code) {
  if (kRed.includes(code)) return 'red';
  if (kAmber.includes(code)) return 'amber';
  return ['HOLD', 'WORKING', 'DONE'].includes(code) ? 'good' : 'plain';
}
// Of what is accumulated: of the back while turning, of a whole turn where one is measured.
function share() {
  if (seen.state === 'TURNING' && seen.turned !== null) return Math.min(1, seen.turned / 360);
  const accumulated = seen.state === 'TURNING' ? seen.back : seen.used;
  return seen.state === 'MEASURED' ? 1 : Math.min(1, accumulated / Math.max(1, hello.frames_wanted));
}

// Who turns does not see the screen: each quarter is heard.
function turned(deg) {
  const before = seen.turned;
  seen.turned = deg === undefined ? null : deg;
  if (before !== null && Math.floor(deg / 90) > Math.floor(before / 90)) sounds.mark('QUARTER');
}

function show() {
  if (!words.table) return;
  const code = codeNow();
  const before = document.body.dataset.code;
  document.body.dataset.stage = stageFor(code);
  document.body.dataset.tone = toneFor(code);
  if (before !== code) {
    document.body.dataset.code = code;
    at('icon').innerHTML = kIcons[code] || '';
  }
  if (at('message').textContent !== words.say(code)) at('message').textContent = words.say(code);
  at('accumulated').value = document.body.dataset.stage === 'measure' ? share() : 0;
  const counts = code === 'HOLD' && share() < 1;
  const turning = seen.state === 'TURNING' && seen.turned !== null && document.body.dataset.stage === 'measure';
  document.body.dataset.turning = String(turning);
  at('count').style.setProperty('--turned', turning ? share() : 0);
  at('count').textContent =
    turning ? `${seen.turned}°` : counts ? String(Math.max(1, Math.ceil(3 * (1 - share())))) : '';
  sounds.say(code);
}

function listItems(texts) {
  return texts.map((text) => Object.assign(document.createElement('li'), {textContent: text}));
}

function showTexts() {
  if (!words.table) return;
  document.documentElement.lang = words.language;
  const page = words.table.page;
  for (const id of ['agree', 'stop', 'size-title', 'name-head', 'interval-head']) {
    at(id).textContent = page[id];
  }
  showBrand();
  at('consent-title').textContent = words.table.consent.title;
  const points = [...words.table.consent.points, ...words.shopPoints(hello.shop), words.table.consent[hello.keeps_files ? 'files' : 'no_files'],
    ...(hello.counts ? [words.table.consent.counted] : [])];
  at('consent-points').replaceChildren(...listItems(points));
  at('sight').setAttribute('aria-label', page.sight);
  at('canvas').setAttribute('aria-label', page.body);
  at('accumulated').setAttribute('aria-label', page.accumulated);
  at('languages').setAttribute('aria-label', page.languages);
  at('try-on').textContent = words.table.tryon.title;
  at('to-phone').textContent = page.to_phone;
  at('to-phone').hidden = !hello.hands_over;
  at('open-figures').textContent = page.figures;
  at('more').textContent = page.more_time;
  showCode();
  at('sound').textContent = sounds.on ? page.sound_on : page.sound_off;
  at('sound').setAttribute('aria-pressed', String(sounds.on));
  for (const button of at('languages').children) {
    button.setAttribute('aria-current', String(button.lang === words.language));
  }
  showRecorded();
  fitting.draw();
  facts.draw();
  showResult();
  show();
}

// Whose shop this is.
function showBrand() {
  const shop = hello.shop;
  at('brand').hidden = !shop;
  if (!shop) return;
  document.title = at('shop').textContent = shop.name;
  at('logo').hidden = !shop.logo;
  if (shop.logo && !at('logo').src) at('logo').src = '/shop.png';
}

// A visit that an operator records: the person is told on every screen, with the text they agreed to, which is open
// while they are recorded. What a press of Delete left is told as well.
let notDeleted = false;
function showRecorded() {
  if (!words.table) return;
  const recorded = Boolean(visit && visit.recorded), ended = recorded && visit.state === 'RESULT';
  const box = at('recorded'), consent = words.table.operator.consent;
  if (box.dataset.state !== `${recorded} ${ended}`) {
    box.hidden = !recorded;
    box.open = recorded && !ended;
    box.dataset.state = `${recorded} ${ended}`;
  }
  at('recorded-words').textContent = words.of(ended ? 'recorded' : 'recording');
  at('recorded-title').textContent = consent.title;
  at('recorded-points').replaceChildren(...listItems([...consent.points, ...words.shopPoints(hello.shop)]));
  at('delete').textContent = words.of(recorded ? 'delete_recording' : 'delete');
  at('not-deleted').hidden = !notDeleted;
  at('not-deleted').textContent = notDeleted ? words.of('not_deleted') : '';
}

// What stands beside the answer, in plain words.
function showDoubts() {
  const sentences = result ? words.doubts(result) : [];
  at('doubts').hidden = sentences.length === 0;
  at('doubts').textContent = sentences.join(' ');
}

function showSize() {
  const likely = Object.entries(result.size ? result.size.probabilities : {}).sort((a, b) => b[1] - a[1]).slice(0, 2);
  const chances = document.createElement('small');
  chances.textContent = ' ' + likely.map(([size, p]) => `${size} ${words.percent(p)}`).join(', ');
  at('size').replaceChildren(...(result.size ? [result.size.best, chances] : []));
}

function showResult() {
  if (!words.table) return;  // a result may come before the texts have; showTexts() shows it then
  at('unit').textContent = words.inches ? words.of('centimetres') : words.of('inches');
  if (!result) return;
  at('unit-head').textContent = words.unit('mm');
  at('values').tBodies[0].replaceChildren(...Object.entries(result.measurements).map(([id, m]) => {
    const row = document.createElement('tr');
    row.dataset.id = id;
    const name = document.createElement('th');
    name.scope = 'row';
    name.textContent = words.name(id) + (m.unit === 'kg' ? ` (${words.unit('kg')})` : '');
    row.append(name);
    const [low, high] = m.interval.map((v) => words.value(v, m.unit));
    for (const text of [words.value(m.value, m.unit), `${low} – ${high}`]) row.insertCell().textContent = text;
    return row;
  }));
  showSize();
  showDoubts();
  const notes = [words.of({around: 'around', 'front+back': 'front_and_back'}[result.views] || 'front_only')];
  if (result.clothing.answered_as === 'dressed') notes.push(words.of('dressed'));
  at('others').textContent = notes.join(' ');
}

// One thing beside the body: trying on, the phone's code or the figures.
function showPanel() {
  const wears = fitting.fits.length > 0;
  if (panel === 'phone' && !offer) panel = 'tryon';
  const shown = panel === 'tryon' && !wears ? 'figures' : panel;
  at('try-on').hidden = !wears;
  for (const [id, button] of [['tryon', 'try-on'], ['phone', 'to-phone'], ['figures', 'open-figures']]) {
    at(id).hidden = id !== shown;
    at(button).setAttribute('aria-expanded', String(id === shown));
  }
}

// The code by which a phone takes the result, while it holds.
function showCode() {
  showPanel();
  if (!offer) return;
  const svg = at('code'), margin = 4;  // as readers need it
  svg.setAttribute('viewBox', `${-margin} ${-margin} ${offer.side + 2 * margin} ${offer.side + 2 * margin}`);
  svg.setAttribute('aria-label', offer.address);
  for (const side of ['x', 'y']) svg.firstElementChild.setAttribute(side, -margin);
  svg.lastElementChild.setAttribute('d', offer.path);
  at('type-address').textContent = words.of('type_address');
  // In groups, as one reads and types it.
  const [host, token] = offer.address.split('#');
  at('address').replaceChildren(...[`${host}#`, ...token.match(/.{1,4}/g)].map((part) => {
    return Object.assign(document.createElement('span'), {textContent: part});
  }));
  at('scan').textContent = words.of('scan').replace('{s}', offer.left_s);
}
function endOffer() {
  clearTimeout(offerTimer);
  offer = null;
  at('code').lastElementChild.removeAttribute('d');
  at('code').removeAttribute('aria-label');
  at('address').replaceChildren();
  showCode();
}

// Nothing of a visit stays, whoever's it was.
function forget() {
  endOffer();
  result = null;
  seen = {...kNothingSeen};
  mirror.clear();
  if (stage) stage.removeAvatar();
  panel = 'tryon';
  delete document.body.dataset.near;
  delete document.body.dataset.avatar;
  for (const id of ['size', 'others', 'left']) at(id).replaceChildren();
  showDoubts();
  at('values').tBodies[0].replaceChildren();
  document.dispatchEvent(new CustomEvent('im2fit-forget'));
}

const on = {
  hello(event) {
    if (boot && boot !== event.boot) {  // another run of the program, perhaps another version
      forget();
      location.reload();
      return;
    }
    boot = event.boot;
    hello = event;
    mirror.setBones(event.bones, event.joints);
    camera = '';
    over = false;
    showTexts();
  },
  visit(event) {
    if (visit && visit.id !== event.id) {
      forget();
      words.language = words.home;
      words.inches = words.homeInches;
      visit = event;
      showTexts();
    }
    const tells = event.state === 'FACTS' && (!visit || visit.state !== 'FACTS');
    visit = event;
    if (event.state !== 'ASKING') notDeleted = false;
    showRecorded();
    document.body.dataset.visit = event.id;
    if (!tells) return;
    facts.draw();
    show();
    facts.focus();
  },
  beat(event) {
    const counts = visit && visit.state === 'RESULT' && words.table;
    // Of who is recorded only the screen is cleared: nothing says that the recording goes.
    at('left').textContent = counts ? words.of(visit.recorded ? 'left_recorded' : 'left').replace('{s}', event.left_s) : '';
  },
  trouble(event) { trouble = event.code; },
  state(event) {
    seen.state = event.state;
    seen.guidance = event.guidance;
    seen.details = event.guidance_details;
    seen.used = event.frames_used;
  },
  frame(event) {
    seen.used = event.frames_used;
    seen.back = event.frames_back;
    turned(event.turned_deg);
    mirror.setJoints(event.pixels, codeNow());
    if (stage && event.rotations) stage.pose(event.root, event.rotations);
  },
  picture(event) {
    if (visit && visit.state === 'MEASURING') mirror.load(event.number);
  },
  async measured(event) {
    const whose = visit;
    if (event.corrected) endOffer();  // its code is of the result before
    result = event.result;
    showResult();
    document.dispatchEvent(new CustomEvent('im2fit-result', {detail: result}));
    if (!stage || !whose) return;
    // A result may be without a body, or be deleted while that is on its way.
    const shown = await stage.loadAvatar(`/avatar.glb?${whose.id}`, hello.segments).catch(() => false);
    if (!shown) return;
    document.body.dataset.avatar = event.person;  // whose body stands on the stage
    fitting.dressAsMeasured();
  },
  tryon(event) { fitting.ready(event); },
  cloth() { clothLink.fetch(); },
  camera(event) { camera = event.state === 'PRESENT' ? '' : 'CAMERA_LOST'; },
  end() {
    over = true;
    facts.draw();
  },
};

// --- the link to the program
let stream = null, heardAt = 0;
function lose(why) {
  if (link === why) return;
  link = why;
  visit = null;
  forget();
  showRecorded();
  show();
}
function connect() {
  if (stream) stream.close();
  stream = new EventSource('/events');
  heardAt = Date.now();
  stream.onmessage = (message) => {
    heardAt = Date.now();
    link = '';
    const event = JSON.parse(message.data);
    if (on[event.event]) on[event.event](event);
    show();
  };
  stream.onerror = () => {
    // Answered, but not with a stream: it is there, and has no room.
    const refused = stream.readyState === EventSource.CLOSED;
    lose(refused ? 'TOO_MANY_SCREENS' : 'SERVER_GONE');
    stream.close();
    heardAt = Date.now() - kQuietMs + kReconnectMs;
  };
}
setInterval(() => {
  if (Date.now() - heardAt < kQuietMs) {
    show();  // repeats tones
    return;
  }
  if (!link) lose('SERVER_GONE');
  connect();
}, 250);

// --- what people do
async function ask(action, note = '') {
  if (!visit) return null;
  const headers = {'X-Im2fit-Visit': visit.id, 'X-Im2fit-Note': note};
  try {
    return await fetch(`/${action}`, {method: 'POST', headers});
  } catch (error) {
    return null;  // the stream says that the program has gone
  }
}
at('to-phone').addEventListener('click', async () => {
  const whose = visit;
  if (!whose) return;
  const headers = {'X-Im2fit-Visit': whose.id};
  const answer = await fetch('/hand-over', {method: 'POST', headers}).catch(() => null);
  const given = answer && answer.ok ? await answer.json().catch(() => null) : null;
  if (!given || !visit || visit.id !== whose.id) return;  // over meanwhile
  endOffer();
  offer = given;
  panel = 'phone';
  offerTimer = setTimeout(endOffer, 1000 * given.left_s);
  showCode();
});
for (const [id, shown] of [['try-on', 'tryon'], ['open-figures', 'figures']]) {
  at(id).addEventListener('click', () => {
    panel = shown;
    showPanel();
  });
}
at('more').addEventListener('click', () => ask('touch'));
let touchedAt = 0;
for (const kind of ['pointerdown', 'keydown', 'wheel', 'click']) {
  window.addEventListener(kind, () => {
    sounds.unlock();
    // Who touches the result stands before it: "come here" no longer has to be read from afar.
    if (document.body.dataset.stage === 'result') document.body.dataset.near = 'true';
    if (Date.now() - touchedAt < kTouchMs) return;
    touchedAt = Date.now();
    ask('touch');
  }, {passive: true});
}
at('agree').addEventListener('click', () => {
  sounds.unlock();
  ask('consent', `${words.language}-${words.consentVersion(words.table.consent.version, hello.shop)}`);
});
for (const id of ['delete', 'stop']) {
  at(id).addEventListener('click', async () => {
    const asked = ask('delete');
    forget();
    const answer = await asked;
    notDeleted = Boolean(answer) && answer.status === 500;
    showRecorded();
  });
}
at('unit').addEventListener('click', () => {
  words.inches = !words.inches;
  showResult();
});
at('sound').addEventListener('click', () => {
  sounds.on = !sounds.on;
  showTexts();
});

at('ghost').innerHTML = at('pose').innerHTML = kPose;
words.load().then(() => {
  at('languages').replaceChildren(...kLanguages.map((language) => {
    const button = document.createElement('button');
    button.type = 'button';
    button.lang = language;
    button.textContent = words.tables[language].name;
    button.addEventListener('click', () => {
      words.language = language;
      showTexts();
    });
    return button;
  }));
  showTexts();
});
connect();
