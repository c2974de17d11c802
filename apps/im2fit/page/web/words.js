// SPDX-License-Identifier: Apache-2.0
// Codes in words for the person before the camera. docs/result.md says what each means.
'use strict';

// What to ask for first: who is not wholly in view need not hear about their arms.
const kWishes = [
  ['NO_PERSON', 'Please step in front of the camera'],
  ['TURN_ROUND', 'Please turn round and show your back'],
  ['CLOTHED', 'You seem to be dressed: the figures are less certain'],
  ['SEVERAL_PEOPLE', 'One person at a time, please'],
  ['TOO_NEAR', 'Please step back'],
  ['TOO_FAR', 'Please come closer'],
  ['HEAD_CUT', 'Your head is out of the picture'],
  ['FEET_CUT', 'Your feet are out of the picture'],
  ['SIDE_CUT', 'Please move to the middle of the picture'],
  ['CALIBRATION_POSE', 'Please raise your hands, upper arms level'],
  ['NOT_FRONTAL', 'Please face the camera'],
  ['NOT_UPRIGHT', 'Please stand straight'],
  ['ARMS_CLOSE', 'Hold your arms well away from your body'],
  ['MOVING', 'Please stand still'],
  ['TOO_NOISY', 'The camera does not see well enough'],
];

function armsWish(arms) {
  const which = arms && arms.length === 1 ? `${arms[0]} arm` : 'arms';
  return `Hold your ${which} well away from your body`;
}

function wishFor(state, guidance, details = {}) {
  if (state === 'MEASURED') return 'Done. Please step out of the picture';
  const found = kWishes.find(([code]) => guidance.includes(code));
  if (found) return found[0] === 'ARMS_CLOSE' ? armsWish(details.arms_close) : found[1];
  return state === 'SEARCHING' || state === 'LOST' ? 'Please step in front of the camera' : 'Good, stay like this';
}

const kNames = {
  stature: 'height', sleeve_length: 'sleeve', leg_length: 'leg', shoulder_breadth: 'shoulder breadth',
  neck_girth: 'neck', shoulder_girth: 'shoulders, round', chest_girth: 'chest', waist_girth: 'waist', hip_girth: 'hips',
  inside_leg: 'inside leg', weight: 'weight',
};
function nameOf(id, unit, inches) {
  const name = kNames[id] || id.replace(/_/g, ' ');
  return unit === 'kg' ? `${name}, ${inches ? 'lb' : 'kg'}` : name;
}

// A value of result.json (mm or kg) as people write it.
function written(value, unit, inches) {
  if (value === null) return '–';
  if (unit === 'kg') return inches ? (value * 2.20462).toFixed(0) : value.toFixed(1);
  return inches ? (value / 25.4).toFixed(1) : (value / 10).toFixed(1);
}
