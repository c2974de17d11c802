// SPDX-License-Identifier: Apache-2.0
// Only what arcore/ArCoreFeeder.kt names of it, to compile against.
package com.google.ar.core;

import com.google.ar.core.exceptions.NotYetAvailableException;

public class Frame {
  public Camera getCamera() { return null; }
  public long getTimestamp() { return 0; }
  public android.media.Image acquireRawDepthImage16Bits() throws NotYetAvailableException { throw new NotYetAvailableException(); }
  public android.media.Image acquireRawDepthConfidenceImage() throws NotYetAvailableException { throw new NotYetAvailableException(); }
}
