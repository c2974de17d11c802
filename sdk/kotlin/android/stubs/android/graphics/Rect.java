// SPDX-License-Identifier: Apache-2.0
// Only what sample/DepthFeeder.kt names of it, to compile against.
package android.graphics;

public class Rect {
  public int width() { return 0; }
}
