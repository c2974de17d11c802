// SPDX-License-Identifier: Apache-2.0
// A picture for everything the page says, on 24 x 24, and the pose that is asked for, on 120 x 160. Strokes only: they
// are drawn in the colour of the text.
'use strict';

const kPerson = '<circle cx="12" cy="4" r="2.2"/><path d="M12 7v8M12 15l-3 7M12 15l3 7M12 8.5l-5 4.5M12 8.5l5 4.5"/>';
const kSmallPerson = '<circle cx="6" cy="5" r="2"/><path d="M6 8v7M6 15l-2.5 6M6 15l2.5 6M6 9.5l-3 4M6 9.5l3 4"/>';
const kIcons = {
  WELCOME: kPerson,
  FACTS: '<path d="M5 2.5v19M5 5h4M5 9h2.5M5 13h4M5 17h2.5"/><g transform="translate(2.5 0)">' + kPerson + '</g>',
  NO_PERSON: '<path d="M2 12h7M6 8.5l3.5 3.5L6 15.5"/><g transform="translate(6 0)">' + kPerson + '</g>',
  TURN_ROUND: '<g transform="translate(4.8 4) scale(.6)">' + kPerson + '</g><path d="M20.5 7A10 10 0 1 1 12 2.2M20.5 7l-4.2-.6M20.5 7l.8-4"/>',
  TURN_ON: '<g transform="translate(4.8 4) scale(.6)">' + kPerson + '</g><path d="M12 2.2A10 10 0 1 0 20.5 7M20.5 7l-4.2-.6M20.5 7l.8-4"/>',
  WALK_ROUND: '<g transform="translate(4.8 4) scale(.6)">' + kPerson + '</g><path d="M12 2.2A10 10 0 1 0 20.5 7M20.5 7l-4.2-.6M20.5 7l.8-4"/>',
  TURN_SLOWER: '<g transform="translate(4.8 4) scale(.6)">' + kPerson + '</g><path d="M12 2.2A10 10 0 1 0 20.5 7" stroke-dasharray="2.5 2.5"/>',
  SEVERAL_PEOPLE: kSmallPerson + '<path d="M13 6l8 12M21 6l-8 12"/>',
  STEP_TO_THE_MIDDLE: '<path d="M2 2v20"/><path d="M5 12h5M7.5 9.5L10 12l-2.5 2.5"/><g transform="translate(4.5 0)">' + kPerson + '</g>',
  DEPTH_MISSING: '<circle cx="12" cy="4" r="2.2"/><path d="M12 7v6M12 8.5l-5 4.5M12 8.5l5 4.5"/><path d="M12 15l-3 7M12 15l3 7" stroke-dasharray="1.5 2"/>',
  TOO_NEAR: kSmallPerson + '<path d="M12 12h10M18.5 8.5L22 12l-3.5 3.5"/>',
  TOO_FAR: kSmallPerson + '<path d="M22 12H12M15.5 8.5L12 12l3.5 3.5"/>',
  HEAD_CUT: '<path d="M3 4h18"/><path d="M12 4v9M12 13l-3 8M12 13l3 8M12 6l-5 5M12 6l5 5"/>',
  FEET_CUT: '<path d="M3 20h18"/><circle cx="12" cy="4" r="2.2"/><path d="M12 7v8M12 15l-2.2 5M12 15l2.2 5M12 8.5l-5 4.5M12 8.5l5 4.5"/>',
  SIDE_CUT: kPerson + '<path d="M3 3v18M21 3v18"/>',
  CALIBRATION_POSE: '<circle cx="12" cy="4" r="2.2"/><path d="M12 7v8M12 15l-3 7M12 15l3 7M12 9H6V3M12 9h6V3"/>',
  NOT_FRONTAL: '<circle cx="12" cy="12" r="9"/><path d="M8.5 9.5v1M15.5 9.5v1M8 15c2 2 6 2 8 0"/>',
  NOT_UPRIGHT: kPerson + '<path d="M20 21V3M17.5 5.5L20 3l2.5 2.5"/>',
  ARMS_CLOSE: '<circle cx="12" cy="4" r="2.2"/><path d="M12 7v8M12 15l-3 7M12 15l3 7M12 8.5L5.5 14M12 8.5l6.5 5.5M2 11l1 5 4-1M22 11l-1 5-4-1"/>',
  ARMS_CLOSE_LEFT: '<circle cx="12" cy="4" r="2.2"/><path d="M12 7v8M12 15l-3 7M12 15l3 7M12 8.5L8.5 14M12 8.5L5.5 14M2 11l1 5 4-1"/>',
  ARMS_CLOSE_RIGHT: '<circle cx="12" cy="4" r="2.2"/><path d="M12 7v8M12 15l-3 7M12 15l3 7M12 8.5l3.5 5.5M12 8.5l6.5 5.5M22 11l-1 5-4-1"/>',
  MOVING: '<path d="M8 4h8v16H8z"/><path d="M12 9v6"/>',
  TOO_NOISY: '<path d="M3 12s3.5-6 9-6 9 6 9 6-3.5 6-9 6-9-6-9-6zM4 4l16 16"/>',
  CLOTHED: '<path d="M8 3L3 7l2 4 2-1v11h10V10l2 1 2-4-5-4c-1 2-7 2-8 0z"/>',
  OUT_OF_POPULATION: kSmallPerson + '<path d="M13 3h8M13 21h8M17 3v18M14.5 5.5L17 3l2.5 2.5M14.5 18.5L17 21l2.5-2.5"/>',
  FLOOR_BENT: '<g transform="translate(4.8 0) scale(.6)">' + kPerson + '</g><path d="M2 15c5 8 15 8 20 0"/>',
  FEET_RAISED: '<g transform="translate(4.8 1) scale(.6)">' + kPerson + '</g><path d="M6 15.5h12V19H6zM2 22h20"/>',
  HEAD_UNSEEN: '<circle cx="12" cy="4" r="2.2" stroke-dasharray="1.2 1.6"/><path d="M12 7v8M12 15l-3 7M12 15l3 7M12 8.5l-5 4.5M12 8.5l5 4.5"/>',
  HOLD: '<circle cx="12" cy="12" r="9.5"/><path d="M7 12.5l3.5 3.5L17 9"/>',
  WORKING: '<path d="M7 3h10M7 21h10M8 3c0 5 8 5 8 9s-8 4-8 9M16 3c0 5-8 5-8 9s8 4 8 9"/>',
  DONE: '<path d="M3 13l6 6L21 5"/>',
  OVER: '<path d="M6 4h12v16H6z"/>',
  CAMERA_LOST: '<path d="M3 7h12v10H3zM15 11l6-3v8l-6-3M4 3l16 18"/>',
  NO_CAMERA: '<path d="M3 7h12v10H3zM15 11l6-3v8l-6-3M4 3l16 18"/>',
  MODELS_MISSING: '<path d="M5 3h9l5 5v13H5zM12 9v6M12 18v.5"/>',
  SERVER_GONE: '<path d="M12 3L2 21h20zM12 10v5M12 18v.5"/>',
  TOO_MANY_SCREENS: '<path d="M3 4h18v12H3zM8 20h8M9 7l6 6M15 7l-6 6"/>',
};
// Front and back look alike: arms about 35 degrees off the trunk, feet apart.
const kPose = '<circle cx="60" cy="20" r="8" stroke-width="8" fill="currentColor"/><path stroke-width="24" d="M60 47v32"/>' +
              '<path stroke-width="9" d="M50 42L26 88M70 42l24 46"/><path stroke-width="12" d="M54 84l-9 64M66 84l9 64"/>';
