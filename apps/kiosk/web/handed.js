// SPDX-License-Identifier: Apache-2.0
// A result on the phone it was handed to. The token stands behind the '#' of the address, which browsers do not
// send; it is taken from there, used once, and what comes for it is kept by this page alone.
'use strict';

const at = (id) => document.getElementById(id);
const words = new Words(new URLSearchParams(location.search).get('lang') || navigator.language || 'en');
let taken = null, state = '';  // result.json; then 'once', 'gone' or 'lost'
let shop = null;  // its name, and whether it has a logo; null: nobody is named

// Null: there is nothing (any more) for this token.
async function take(token) {
  const answer = await fetch('/take', {method: 'POST', headers: {'X-Im2fit-Token': token}});
  return answer.ok ? answer.json() : null;
}

// Null: nobody is named, or it could not be asked.
async function askShop() {
  try {
    const answer = await fetch('/shop.json');
    return answer.ok ? await answer.json() : null;
  } catch (error) {
    return null;
  }
}

// Of each measurement: name, value and interval, as people write them.
function rows() {
  return Object.entries(taken.measurements).map(([id, m]) => {
    const [low, high] = m.interval.map((v) => words.value(v, m.unit));
    const unit = m.unit === 'kg' ? ` (${words.unit('kg')})` : '';
    return {id, name: words.name(id) + unit, value: words.value(m.value, m.unit), interval: `${low} – ${high}`};
  });
}
function asText(list) {
  const size = taken.size ? [`${words.table.page['size-title']}: ${taken.size.best}`] : [];
  const lines = list.map((row) => `${row.name}: ${row.value} (${row.interval})`);
  return [...(shop ? [shop.name] : []), ...size, ...words.doubts(taken), `${words.unit('mm')}, ${words.table.page['interval-head']}`, ...lines, ''].join('\n');
}
function offer(id, text, type) {
  URL.revokeObjectURL(at(id).href);
  at(id).href = URL.createObjectURL(new Blob([text], {type}));
}

function show() {
  document.documentElement.lang = words.language;
  const handed = words.table.handed;
  at('title').textContent = handed.title;
  at('brand').hidden = !shop;
  if (shop) {
    document.title = at('shop').textContent = shop.name;
    at('logo').hidden = !shop.logo;
    if (shop.logo && !at('logo').src) at('logo').src = '/shop.png';
  }
  at('note').textContent = state === 'lost' ? words.say('SERVER_GONE') : handed[state] || '';
  document.body.dataset.state = state;
  at('taken').hidden = !taken;
  if (!taken) return;
  for (const id of ['name-head', 'interval-head']) at(id).textContent = words.of(id);
  at('unit-head').textContent = words.unit('mm');
  at('unit').textContent = words.inches ? words.of('centimetres') : words.of('inches');
  at('size').textContent = taken.size ? `${words.table.page['size-title']}: ${taken.size.best}` : '';
  at('doubts').textContent = words.doubts(taken).join(' ');
  const list = rows();
  at('values').tBodies[0].replaceChildren(...list.map((row) => {
    const line = document.createElement('tr'), name = document.createElement('th');
    line.dataset.id = row.id;
    name.scope = 'row';
    name.textContent = row.name;
    line.append(name);
    for (const text of [row.value, row.interval]) line.insertCell().textContent = text;
    return line;
  }));
  offer('text', asText(list), 'text/plain');
  offer('result', JSON.stringify(taken, null, 2), 'application/json');
}

at('unit').addEventListener('click', () => {
  words.inches = !words.inches;
  show();
});
async function begin() {
  const token = location.hash.slice(1).toLowerCase();  // a keyboard may have made it begin with a capital
  await words.load();  // first: without texts nothing could be shown for a token that is used up
  shop = await askShop();
  try {
    taken = token ? await take(token) : null;
    state = taken ? 'once' : 'gone';
    history.replaceState(null, '', location.pathname + location.search);  // it is of no use any more
  } catch (error) {
    state = 'lost';
  }
  show();
}
begin();
