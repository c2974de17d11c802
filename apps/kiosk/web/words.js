// SPDX-License-Identifier: Apache-2.0
// Texts, numbers and units in the language chosen: one file a language, /lang/xx.json.
'use strict';

const kLanguages = ['en', 'de', 'es', 'fr', 'zh'];
// What to ask for first: who is not wholly in view need not hear about their arms.
const kOrder = ['NO_PERSON', 'TURN_ROUND', 'TURN_SLOWER', 'WALK_ROUND', 'SEVERAL_PEOPLE', 'TOO_NEAR', 'TOO_FAR', 'HEAD_CUT', 'FEET_CUT', 'SIDE_CUT',
                'STEP_TO_THE_MIDDLE', 'DEPTH_MISSING', 'CALIBRATION_POSE', 'NOT_FRONTAL', 'NOT_UPRIGHT', 'ARMS_CLOSE', 'MOVING', 'TOO_NOISY',
                'FLOOR_BENT', 'OUT_OF_POPULATION', 'TURN_ON', 'FEET_RAISED', 'HEAD_UNSEEN', 'CLOTHED'];
// Unicode CLDR, measurementSystem: the regions that measure people in inches and pounds.
const kInchRegions = ['US', 'LR', 'MM'];

// The code of what to say to the person in view. Sets of one arm name it.
function codeFor(state, guidance, details = {}) {
  if (state === 'MEASURED') return 'WORKING';
  const found = kOrder.find((code) => guidance.includes(code));
  if (found === 'ARMS_CLOSE' && details.arms_close && details.arms_close.length === 1) {
    return `ARMS_CLOSE_${details.arms_close[0].toUpperCase()}`;
  }
  if (found) return found;
  return state === 'SEARCHING' || state === 'LOST' ? 'NO_PERSON' : 'HOLD';
}

class Words {
  constructor(locale) {
    this.locale = locale;
    this.tables = {};
    this.home = kLanguages.find((l) => locale.toLowerCase().startsWith(l)) || 'en';
    this.language = this.home;
    const region = locale.split('-').pop().toUpperCase();
    this.homeInches = kInchRegions.includes(region);
    this.inches = this.homeInches;
  }
  // All at once: without the program there is nothing to fetch them from.
  load() {
    return Promise.all(kLanguages.map(async (language) => {
      this.tables[language] = await (await fetch(`/lang/${language}.json`)).json();
    }));
  }
  get table() { return this.tables[this.language]; }
  say(code) { return this.table.say[code]; }
  of(key) { return this.table.page[key]; }
  name(id) { return this.table.measurements[id]; }
  // Where the language is that of the browser, its region decides how numbers are written.
  number(value, digits) {
    const locale = this.locale.startsWith(this.language) ? this.locale : this.language;
    return new Intl.NumberFormat(locale, {minimumFractionDigits: digits, maximumFractionDigits: digits}).format(value);
  }
  // A sentence for each code that stands beside the answer of this result.json.
  doubts(result) {
    const {ground_mm: ground, heels_mm: heels} = (result.guidance_details || {}).feet_raised || {};
    const mm = heels === undefined ? ground : heels;
    const height = mm === undefined ? '' : `${this.value(mm, 'mm')} ${this.unit('mm')}`;
    const said = (code) => (code === 'FEET_RAISED' && heels !== undefined ? 'HEELS_RAISED' : code);
    return Object.keys(this.table.doubts).filter((code) => (result.guidance || []).includes(code))
      .map((code) => this.table.doubts[said(code)].replace('{h}', height));
  }
  // Who measures, what for, and whom to ask: what a shop adds to a consent.
  shopPoints(shop) {
    if (!shop || !shop.consent) return [];
    const {operator, purpose, contact} = shop.consent, texts = this.table.shop;
    return [texts.operator.replace('{operator}', () => operator),
      texts.purpose.replace('{purpose}', () => purpose[this.language] || purpose.en),
      texts.contact.replace('{contact}', () => contact)];
  }
  consentVersion(own, shop) { return shop && shop.consent ? `${own}+${shop.consent.version}` : own; }
  percent(share) { return new Intl.NumberFormat(this.language, {style: 'percent'}).format(share); }
  unit(unit) {
    const short = unit === 'kg' ? (this.inches ? 'lb' : 'kg') : this.inches ? 'in' : 'cm';
    return this.table.units[short];
  }
  // A value of result.json (mm or kg) as people write it, without its unit.
  value(value, unit) {
    if (value === null) return '–';
    if (unit === 'kg') return this.inches ? this.number(value * 2.20462, 0) : this.number(value, 1);
    return this.number(this.inches ? value / 25.4 : value / 10, 1);
  }
}
