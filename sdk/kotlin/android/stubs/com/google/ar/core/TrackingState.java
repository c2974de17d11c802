// SPDX-License-Identifier: Apache-2.0
// Only what arcore/ArCoreFeeder.kt names of it, to compile against.
package com.google.ar.core;

public enum TrackingState { TRACKING, PAUSED, STOPPED }
