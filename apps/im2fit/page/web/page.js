// SPDX-License-Identifier: Apache-2.0
// What the program publishes at /events, shown. Its events are those of docs/result.md and docs/page.md.
'use strict';

const at = (id) => document.getElementById(id);
const seen = {state: 'SEARCHING', guidance: ['NO_PERSON'], details: {}, camera: null, wanted: 30, used: 0, back: 0, over: false};
const failures = [];  // what went wrong here, for who looks into it
for (const kind of ['error', 'unhandledrejection']) {
  window.addEventListener(kind, (e) => failures.push(String(e.message || e.reason)));
}
let result = null;
let inches = false;
let segments = [];
let stage = null;
try {
  stage = new Stage(at('canvas'));
} catch (error) {
  at('stage-caption').textContent = 'This browser shows no 3D (WebGL)';
}

function showState() {
  document.body.dataset.state = seen.state;
  at('wish').textContent = seen.camera || (seen.over ? 'The recording is over' : wishFor(seen.state, seen.guidance, seen.details));
  at('codes').textContent = seen.over ? '' : seen.guidance.join(', ');
  const accumulated = seen.state === 'TURNING' ? seen.back : seen.used;
  at('accumulated').value = seen.state === 'MEASURED' ? 1 : Math.min(1, accumulated / seen.wanted);
}

function showSize() {
  at('size').replaceChildren();
  if (!result.size) return;
  const likely = Object.entries(result.size.probabilities).sort((a, b) => b[1] - a[1]).slice(0, 2);
  const chances = document.createElement('small');
  chances.textContent = ' ' + likely.map(([size, p]) => `${size} ${Math.round(100 * p)} %`).join(', ') +
                        ` (${result.size.chart})`;
  at('size').append(result.size.best, chances);
}

function showResult() {
  if (!result) return;
  at('unit-of').textContent = inches ? 'in' : 'cm';
  at('unit').textContent = inches ? 'centimetres' : 'inches';
  at('values').tBodies[0].replaceChildren(...Object.entries(result.measurements).map(([id, m]) => {
    const row = document.createElement('tr');
    const [low, high] = m.interval.map((v) => written(v, m.unit, inches));
    for (const text of [nameOf(id, m.unit, inches), written(m.value, m.unit, inches), `${low} to ${high}`]) {
      row.insertCell().textContent = text;
    }
    return row;
  }));
  showSize();
  const female = result.sex.female;
  const sex = female >= 0.5 ? `female ${Math.round(100 * female)} %` : `male ${Math.round(100 - 100 * female)} %`;
  at('others').textContent = sex + (result.views === 'front+back' ? ', from front and back' : ', from the front') +
                             (result.clothing.answered_as === 'dressed' ? ', through clothes' : '');
}

const on = {
  hello(event) {
    seen.wanted = event.frames_wanted;
    segments = event.segments;
    if (stage) stage.setBones(event.bones, event.joints);
  },
  state(event) {
    seen.state = event.state;
    seen.guidance = event.guidance;
    seen.details = event.guidance_details;
    seen.used = event.frames_used;
    showState();
  },
  frame(event) {
    seen.used = event.frames_used;
    seen.back = event.frames_back;
    showState();
    if (!stage) return;
    stage.setJoints(event.joints);
    if (event.rotations) stage.pose(event.root, event.rotations);
  },
  picture(event) {
    at('picture').src = `/picture.png?${event.number}`;
  },
  async measured(event) {
    result = event.result;
    at('who').textContent = `Person ${event.person}`;
    at('answer').classList.remove('left');
    at('result').hidden = at('avatar').hidden = false;
    showResult();
    fitting.measured(event);
    if (!stage) return;
    const shown = await stage.loadAvatar(`/avatar.glb?${event.person}`, segments);
    if (shown) document.body.dataset.avatar = event.person;  // whose body stands on the stage
  },
  tryon(event) {
    fitting.ready(event);
  },
  left(event) {
    at('who').textContent = `Person ${event.person}, who has left`;
    at('answer').classList.add('left');
    if (stage) stage.removeAvatar();
    delete document.body.dataset.avatar;
  },
  camera(event) {
    seen.camera = event.state === 'PRESENT' ? null : 'The camera is away';
    showState();
  },
  end() {
    seen.over = true;
    showState();
  },
};

at('unit').addEventListener('click', () => {
  inches = !inches;
  showResult();
});
const stream = new EventSource('/events');
stream.onmessage = (message) => {
  const event = JSON.parse(message.data);
  if (on[event.event]) on[event.event](event);
};
stream.onopen = () => {
  seen.camera = null;
  showState();
};
stream.onerror = () => {
  seen.camera = 'The program has ended, or cannot be reached';
  showState();
};
