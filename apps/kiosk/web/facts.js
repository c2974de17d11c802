// SPDX-License-Identifier: Apache-2.0
// The optional form: height, weight, sex, age, by touch alone. A value counts once a person has touched it. Nothing of
// it stays here: values go with the form, and the result has the facts that were sent (`known`, docs/result.md).
'use strict';

// In mm, kg and completed years.
const kNumbers = {
  stature: {start: 1700, least: 1000, most: 2300},
  weight: {start: 70, least: 20, most: 250},
  age: {start: 35, least: 5, most: 110},
};
const kSexes = ['woman', 'man', ''];
const kKgPerPound = 0.45359237;
// Steps of a button that is held down: the first after a while, then faster.
const kHoldMs = 400, kStepMs = 90, kFastMs = 35, kFastAfter = 15;
const kAnswerMs = 60000;  // a corrected answer takes some seconds, on slow machines more

class Facts {
  constructor(root, told) {
    this.root = root;
    this.told = told;      // below the result: which facts it rests on
    this.rows = {};
    this.open = false;     // over a result
    this.answer = '';      // of the program to corrected facts: 'wait', 'late', ''
    this.result = null;
    this.clear();
    this.build();
  }
  get texts() { return words.table.facts; }

  clear() {
    this.values = {stature: null, weight: null, age: null};
    this.sex = '';
    this.scale = false;
  }
  forget() {
    clearTimeout(this.timer);
    this.clear();
    this.open = false;
    this.answer = '';
    this.result = null;
    this.told.replaceChildren();
    this.draw();
  }

  // --- elements, once
  element(tag, box, properties = {}) {
    const e = Object.assign(document.createElement(tag), properties);
    box.append(e);
    return e;
  }
  build() {
    this.why = this.element('p', this.root, {id: 'facts-why'});
    this.box = this.element('div', this.root, {id: 'facts-box'});
    for (const fact of Object.keys(kNumbers)) {
      const box = this.element('div', this.box, {className: 'fact'});
      box.setAttribute('role', 'group');
      box.dataset.fact = fact;
      const name = this.element('span', box, {className: 'name', id: `fact-${fact}`});
      box.setAttribute('aria-labelledby', name.id);
      const less = this.stepper(fact, -1, box, '−');
      const value = this.element('button', box, {className: 'value', type: 'button'});
      value.addEventListener('click', () => {
        this.values[fact] = this.values[fact] === null ? kNumbers[fact].start : null;
        this.draw();
      });
      this.rows[fact] = {box, name, less, value, more: this.stepper(fact, 1, box, '+')};
    }
    this.unit = this.element('button', this.rows.weight.box, {type: 'button', id: 'facts-unit'});
    this.unit.addEventListener('click', () => {
      words.inches = !words.inches;
      this.draw();
      showResult();
    });
    const scale = this.element('label', this.rows.weight.box, {className: 'switch'});
    this.scaleBox = this.element('input', scale, {type: 'checkbox', id: 'facts-scale'});
    this.scaleBox.addEventListener('change', () => { this.scale = this.scaleBox.checked; });
    this.scaleName = this.element('span', scale);
    const sexes = this.element('fieldset', this.box, {className: 'fact'});
    sexes.dataset.fact = 'sex';
    this.sexName = this.element('legend', sexes, {className: 'name'});
    const segments = this.element('div', sexes, {className: 'segments'});
    this.sexes = kSexes.map((sex) => {
      const label = this.element('label', segments);
      const radio = this.element('input', label, {type: 'radio', name: 'sex', value: sex});
      radio.addEventListener('change', () => { this.sex = sex; });
      return {radio, name: this.element('span', label)};
    });
    const actions = this.element('div', this.root, {id: 'facts-actions'});
    const button = (id, act) => {
      const e = this.element('button', actions, {type: 'button', id});
      e.addEventListener('click', act);
      return e;
    };
    this.skip = button('facts-skip', () => (this.open ? this.close() : this.send({})));
    this.go = button('facts-go', () => this.send(this.given()));
    this.go.className = 'main';
  }
  // A touch is a step, and so is the keyboard's click; held down it goes on.
  stepper(fact, direction, box, sign) {
    const button = this.element('button', box, {type: 'button', textContent: sign});
    button.className = `step ${direction < 0 ? 'less' : 'more'}`;
    let timer = 0, repeated = 0;
    const stop = () => { clearTimeout(timer); };
    const again = () => {
      ++repeated;
      this.step(fact, direction);
      timer = setTimeout(again, repeated < kFastAfter ? kStepMs : kFastMs);
    };
    button.addEventListener('pointerdown', () => {
      repeated = 0;
      stop();
      timer = setTimeout(again, kHoldMs);
    });
    for (const end of ['pointerup', 'pointercancel', 'pointerleave', 'blur']) button.addEventListener(end, stop);
    button.addEventListener('contextmenu', (event) => event.preventDefault());  // of a long touch
    button.addEventListener('click', () => {
      stop();
      if (repeated === 0) this.step(fact, direction);
      repeated = 0;
    });
    return button;
  }

  // --- values
  // What one step is, in mm, kg or years.
  unitOf(fact) {
    if (fact === 'stature') return words.inches ? 25.4 : 10;
    return fact === 'weight' && words.inches ? kKgPerPound : 1;
  }
  // The first touch takes the value that people begin with.
  step(fact, direction) {
    const {start, least, most} = kNumbers[fact], unit = this.unitOf(fact), now = this.values[fact];
    const next = now === null ? start : (Math.round(now / unit) + direction) * unit;
    this.values[fact] = Math.min(most, Math.max(least, next));
    this.draw();
  }
  shown(fact) {
    const steps = Math.round(this.values[fact] / this.unitOf(fact));
    if (fact === 'age') return this.texts.years.replace('{n}', words.number(steps, 0));
    if (fact === 'weight') return `${words.number(steps, 0)} ${words.unit('kg')}`;
    return words.inches ? `${Math.floor(steps / 12)}′ ${steps % 12}″` : `${words.number(steps, 0)} ${words.unit('mm')}`;
  }
  // As POST /facts takes it.
  given() {
    const {stature, weight, age} = this.values, facts = {};
    if (stature !== null) facts.height_mm = stature;
    if (weight !== null) Object.assign(facts, {weight_kg: weight, weight_from: this.scale ? 'scale' : 'stated'});
    if (this.sex) facts.sex = this.sex;
    if (age !== null) facts.age = age;
    return facts;
  }

  draw() {
    if (!words.table) return;
    const doubted = this.open && this.result && this.result.known ? this.result.known.doubted : [];
    const doubts = doubted.map((fact) => this.texts.doubted[fact]);
    this.why.textContent = [...doubts, ...(doubts.length ? [] : [this.texts.why])].join(' ');
    this.why.dataset.doubted = String(doubts.length > 0);
    for (const [fact, row] of Object.entries(this.rows)) {
      const known = this.values[fact] !== null, name = this.texts.names[fact];
      row.box.dataset.doubted = String(doubted.includes(fact));
      row.name.textContent = name;
      row.less.setAttribute('aria-label', `${name} −`);
      row.more.setAttribute('aria-label', `${name} +`);
      row.value.textContent = known ? this.shown(fact) : this.texts.unset;
      row.value.setAttribute('aria-pressed', String(known));
      row.value.setAttribute('aria-live', 'polite');
    }
    this.scaleName.textContent = this.texts.scale;
    this.scaleBox.checked = this.scale;
    this.sexName.textContent = this.texts.names.sex;
    this.sexes.forEach(({radio, name}, i) => {
      radio.checked = this.sex === kSexes[i];
      name.textContent = this.texts.sexes[i];
    });
    this.unit.textContent = words.inches ? this.texts.centimetres : this.texts.feet;
    this.skip.textContent = this.open ? this.texts.back : this.texts.skip;
    this.go.textContent = this.texts.go_on;
    this.drawTold();
  }

  // --- over a result
  // Of a result and, where it was corrected, of the one before.
  measured(result) {
    clearTimeout(this.timer);
    this.answer = '';
    this.result = result;
    this.draw();
  }
  correct() {
    const given = this.result && this.result.known ? this.result.known.given : {};
    this.clear();
    if (given.stature) this.values.stature = given.stature.value;
    if (given.weight) this.values.weight = given.weight.value;
    if (given.weight) this.scale = given.weight.sd < 1;
    if (given.age) this.values.age = Math.floor(given.age.value);
    this.sex = given.sex || '';
    this.open = true;
    this.draw();
    show();
    this.focus();
  }
  close() {
    this.open = false;
    this.clear();
    this.draw();
    show();
    const button = at('facts-open');
    if (button) button.focus();
  }
  focus() { this.root.focus({preventScroll: true}); }

  // "" without the option, or in a visit that the operator records.
  canCorrect() { return hello.asks_facts && visit && !visit.recorded && !over; }
  drawTold() {
    this.told.replaceChildren();
    if (!this.result || !words.table) return;
    const known = this.result.known || {used: [], doubted: []};
    const line = (text, doubted = false) => {
      this.element('p', this.told, {textContent: text}).dataset.doubted = String(doubted);
    };
    if (this.answer) {
      line(this.texts[this.answer]);
    } else {
      const names = known.used.map((fact) => this.texts.yours[fact]);
      const list = new Intl.ListFormat(words.language, {type: 'conjunction'}).format(names);
      if (names.length) line(this.texts.used.replace('{facts}', list));
      for (const fact of known.doubted) line(this.texts.doubted[fact], true);
    }
    if (!this.canCorrect() || this.answer === 'wait') return;
    const button = this.element('button', this.told, {type: 'button', id: 'facts-open'});
    button.textContent = known.doubted.length ? this.texts.check : this.texts.open;
    button.addEventListener('click', () => this.correct());
  }

  async send(facts) {
    const whose = visit;
    if (!whose || this.sending) return;
    this.sending = true;
    const headers = {'X-Im2fit-Visit': whose.id, 'Content-Type': 'application/json'};
    const answer = await fetch('/facts', {method: 'POST', headers, body: JSON.stringify(facts)}).catch(() => null);
    this.sending = false;
    if (!visit || visit.id !== whose.id) return;  // over meanwhile; forget() was called
    if (!this.open) {
      if (answer && answer.ok) this.clear();  // else they can be sent again
      this.draw();
      return;  // the program says what comes next
    }
    this.answer = answer && answer.ok ? 'wait' : 'late';
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      this.answer = 'late';
      this.draw();
    }, kAnswerMs);
    if (this.answer === 'late') clearTimeout(this.timer);
    this.close();
  }
}
