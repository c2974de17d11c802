// SPDX-License-Identifier: Apache-2.0
// Trying clothes on: which garments and sizes, bare or dressed, the map of ease. `fit` of result.json says how each
// size sits, which is told in one sentence; /tryon.glb is the body in it (docs/page.md).
'use strict';

const kTops = ['t_shirt', 'long_sleeved_shirt', 'dress'];  // what hangs from the shoulders; the rest from the waist

class Fitting {
  // `view`: where the switches of the picture stand.
  constructor(root, view) {
    this.root = root;
    this.view = view;
    this.part = 'top';  // the one that is chosen now
    this.visit = '';
    this.fits = [];
    this.worn = {top: null, bottom: null};  // {garment, size}
    this.bare = false;
    this.ease = false;
    this.asked = null;   // the query wanted
    this.shown = null;   // the query on the stage; null: the avatar as measured
    this.asking = false;
    this.status = '';
    this.quiet = false;  // what is asked for was not chosen by a person
    this.second = null;  // the other size, side by side: {part, size}
    this.askedBeside = this.shownBeside = null;  // its queries, as those above
  }

  fit(id) { return this.fits.find((f) => f.garment === id); }

  // `result`: result.json of the visit with this id.
  measured(result, visit) {
    this.visit = visit;
    this.fits = result.fit || [];
    this.bare = this.ease = false;
    this.asked = this.shown = this.askedBeside = this.shownBeside = this.second = null;
    this.status = '';
    for (const [part, id] of [['top', 't_shirt'], ['bottom', 'trousers']]) {
      const fit = this.fit(id);
      this.worn[part] = fit ? {garment: id, size: fit.best} : null;
    }
    this.part = this.worn.top || !this.worn.bottom ? 'top' : 'bottom';
    this.below = null;
    this.draw();
    showPanel();
  }

  forget() {
    clearTimeout(this.later);
    this.visit = '';
    this.fits = [];
    this.asked = this.shown = this.askedBeside = this.shownBeside = this.second = null;
    this.drawSides();
    this.root.replaceChildren();
    this.view.replaceChildren();
    showPanel();
  }

  // `second`: of the other size.
  query(second = null) {
    const fields = new URLSearchParams({visit: this.visit});
    for (const part of ['top', 'bottom']) {
      if (this.bare || !this.worn[part]) continue;
      fields.set(part, this.worn[part].garment);
      fields.set(`${part}_size`, second && second.part === part ? second.size : this.worn[part].size);
    }
    if (this.ease && !this.bare) fields.set('colours', 'ease');
    return fields.toString();
  }

  changed() {
    this.quiet = false;
    this.asked = this.query();
    if (this.bare || !this.second || !this.worn[this.second.part]) this.second = null;
    this.askedBeside = this.second && this.query(this.second);
    if (!this.second && this.shownBeside) {
      this.shownBeside = this.shown = null;  // the avatar once more, with cloth that moves
      if (stage) stage.removeBeside();
    }
    this.draw();
    this.ask();
  }

  // The neighbour of the worn size that is likelier to fit: the larger one, or the smaller one of the largest.
  compare() {
    const worn = this.worn[this.part];
    if (this.second || !worn) {
      this.second = null;
    } else {
      const sizes = Fitting.ordered(this.fit(worn.garment)).map(([size]) => size), at = sizes.indexOf(worn.size);
      const other = sizes[at + 1] || sizes[at - 1];
      this.second = other ? {part: this.part, size: other} : null;
    }
    this.bare = false;
    this.changed();
  }
  // From small to large: names do not tell.
  static ordered(fit) {
    const sum = (regions) => Object.values(regions).reduce((all, r) => all + r.ease_mm, 0);
    return Object.entries(fit.sizes).sort((a, b) => sum(a[1]) - sum(b[1]));
  }
  wornIsSmaller() {
    const worn = this.worn[this.second.part];
    const sizes = Fitting.ordered(this.fit(worn.garment)).map(([size]) => size);
    return sizes.indexOf(worn.size) < sizes.indexOf(this.second.size);
  }
  pending() { return this.asked !== this.shown || this.askedBeside !== this.shownBeside; }

  // The avatar as measured, once more: with cloth that moves. No person chose it, so a failure is not shown.
  dressAsMeasured() {
    if (this.fits.length === 0 || this.asked !== null) return;
    this.quiet = true;
    this.asked = this.query();
    this.ask();
  }

  ready(event) {
    if (event.visit === this.visit) this.ask();
  }

  // The room makes one at a time and says when it is done; a word may be missed, so it is asked now and then as well.
  async ask() {
    if (this.asking || this.asked === null || !this.pending()) return;
    this.asking = true;
    const first = this.asked !== this.shown;  // else the other size is wanted
    const query = first ? this.asked : this.askedBeside;
    const wanted = () => query === (first ? this.asked : this.askedBeside);
    let status = 'failed';
    try {
      const answer = await fetch(`/tryon.glb?${query}`, {method: 'HEAD'});
      if (answer.status === 202) {
        status = 'dressing';
        clearTimeout(this.later);
        this.later = setTimeout(() => this.ask(), 1500);
      } else if (answer.ok) {
        status = '';
        if (wanted()) clothLink.end();  // offsets of one avatar are none of another's
        if (wanted() && await this.show(`/tryon.glb?${query}`, first)) {
          if (first) this.shown = query;
          else this.shownBeside = query;
          if (first && !this.second) clothLink.begin(query);  // two move with the skeleton, to be like each other
        }
      }
    } catch (error) {
      status = 'failed';  // the program has ended, or what was made is kept no longer
    } finally {
      this.asking = false;
      this.status = status;
      this.drawStatus();
    }
    if (!wanted() || (first && this.shown === query && this.pending())) this.ask();
  }

  // In the pose the body has.
  async show(url, first) {
    if (!stage) return true;
    if (!first) return stage.loadBeside(url, hello.segments, this.wornIsSmaller());
    const wanted = stage.wanted;
    const shown = await stage.loadAvatar(url, hello.segments);
    if (shown && wanted) {
      stage.wanted = wanted;
      stage.requestDraw();
    }
    return shown;
  }

  element(tag, words, parent, properties = {}) {
    const made = Object.assign(document.createElement(tag), {textContent: words}, properties);
    if (parent) parent.append(made);
    return made;
  }

  button(words, pressed, parent, press) {
    const made = this.element('button', words, parent, {type: 'button', onclick: press});
    made.setAttribute('aria-pressed', pressed);
    return made;
  }

  get texts() { return words.table.tryon; }

  draw() {
    this.root.replaceChildren();
    this.view.replaceChildren();
    if (this.fits.length === 0 || !words.table) return;
    this.root.setAttribute('aria-label', this.texts.title);
    this.view.setAttribute('aria-label', words.of('body'));
    this.button(this.texts.bare, this.bare, this.view, () => { this.bare = !this.bare; this.changed(); }).id = 'fitting-bare';
    const ease = this.button(this.texts.ease, this.ease, this.view, () => { this.ease = !this.ease; this.changed(); });
    ease.id = 'fitting-ease';
    ease.disabled = this.bare;
    if (this.worn[this.part]) {
      this.button(this.texts.compare, Boolean(this.second), this.view, () => this.compare()).id = 'fitting-compare';
    }
    if (this.ease && !this.bare) this.drawLegend(this.view);
    this.drawSides();
    const parts = this.element('div', '', this.root, {className: 'row parts'});
    for (const part of ['top', 'bottom']) {
      const tab = this.button(this.texts[part], this.part === part, parts, () => {
        this.part = part;
        this.draw();
      });
      tab.dataset.part = part;
    }
    this.drawPart(this.part, this.root);
    this.element('p', '', this.root, {id: 'fitting-status'}).setAttribute('role', 'status');
    this.drawStatus();
  }

  drawStatus() {
    const line = document.getElementById('fitting-status');
    const waits = this.asked !== null && this.pending();
    const code = this.quiet ? '' : this.status || (waits ? 'dressing' : '');
    if (line) line.textContent = code ? this.texts[code] : '';
  }

  // Two sizes: what each is like, on the picture; one in the panel.
  drawSides() {
    const sides = document.getElementById('sides');
    sides.hidden = !this.second || !words.table;
    sides.replaceChildren();
    document.body.toggleAttribute('data-compares', !sides.hidden);
    if (sides.hidden) return;
    const worn = this.worn[this.second.part], fit = this.fit(worn.garment);
    const both = this.wornIsSmaller() ? [worn.size, this.second.size] : [this.second.size, worn.size];
    for (const size of both) {
      const how = this.texts.verdict.replace('{size}', size).replace('{how}', this.sentence(fit.sizes[size]));
      this.element('p', how, sides, {className: `verdict ${Fitting.worst(fit.sizes[size])}`}).dataset.size = size;
    }
  }

  drawLegend(parent) {
    const legend = this.element('span', '', parent, {className: 'legend'});
    this.texts.legend.forEach((words, i) => this.element('span', words, legend, {className: ['tight', 'good', 'loose'][i]}));
  }

  wear(part, garment) {
    const before = this.worn[part];
    this.second = null;  // sizes of one garment are compared
    this.worn[part] = garment ? {garment, size: this.fit(garment).best} : null;
    if (part === 'top') {  // a dress takes the place of both; after it trousers come back
      if (garment === 'dress' && this.worn.bottom) [this.below, this.worn.bottom] = [this.worn.bottom, null];
      else if (before && before.garment === 'dress' && !this.worn.bottom) this.worn.bottom = this.below;
    }
    this.bare = false;
    this.changed();
  }

  drawPart(part, parent) {
    const box = this.element('div', '', parent, {className: 'part', id: `fitting-${part}`});
    const garments = this.element('div', '', box, {className: 'row garments'});
    const worn = this.worn[part];
    for (const {garment} of this.fits.filter((f) => kTops.includes(f.garment) === (part === 'top'))) {
      const press = () => this.wear(part, garment);
      this.button(this.texts.garments[garment] || garment, Boolean(worn) && worn.garment === garment, garments,
                  press).dataset.garment = garment;
    }
    this.button(this.texts.none, !worn, garments, () => this.wear(part, null));
    if (worn) this.drawSizes(part, this.fit(worn.garment), box);
  }

  // What a size is like, and why: "a bit tight at the waist".
  sentence(regions) {
    const like = (verdict) => {
      const where = Object.keys(regions).filter((r) => regions[r].verdict === verdict)
        .map((r) => this.texts.regions[r] || r);
      const list = new Intl.ListFormat(words.language, {type: 'conjunction'}).format(where);
      return where.length ? this.texts.verdicts[verdict].replace('{where}', list) : '';
    };
    const tight = like('tight') || like('snug');  // what is too tight says enough
    const found = [tight, like('loose')].filter((text) => text);
    return found.join(', ') || this.texts.verdicts.good;
  }
  static worst(regions) {
    const verdicts = Object.values(regions).map((r) => r.verdict);
    return ['tight', 'loose', 'snug'].find((v) => verdicts.includes(v)) || 'good';
  }

  drawSizes(part, fit, box) {
    const worn = this.worn[part];
    const sizes = this.element('div', '', box, {className: 'row sizes'});
    const second = this.second && this.second.part === part ? this.second : null;
    for (const [size, regions] of Fitting.ordered(fit)) {
      const chip = this.button(size, size === worn.size || Boolean(second && size === second.size), sizes, () => {
        if (second && size === worn.size) return;
        if (second) second.size = worn.size;  // of two that are compared the later choice stays
        worn.size = size;
        this.bare = false;
        this.changed();
      });
      chip.classList.add(Fitting.worst(regions));
      chip.dataset.size = size;
      chip.setAttribute('aria-label', this.texts.verdict.replace('{size}', size).replace('{how}', this.sentence(regions)));
      if (size === fit.best) chip.classList.add('best');
    }
    if (second) return;  // each has its verdict on the picture
    const regions = fit.sizes[worn.size], best = worn.size === fit.best;
    const size = best ? this.texts.best_of.replace('{size}', worn.size)
      .replace('{why}', fit.fits ? this.texts.best : this.texts.closest) : worn.size;
    const text = this.texts.verdict.replace('{size}', size).replace('{how}', this.sentence(regions));
    this.element('p', text, box, {className: `verdict ${Fitting.worst(regions)}`});
  }
}
const fitting = new Fitting(document.getElementById('tryon'), document.getElementById('view'));
document.addEventListener('im2fit-result', (event) => fitting.measured(event.detail, visit.id));
document.addEventListener('im2fit-forget', () => fitting.forget());
