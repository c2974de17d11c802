// SPDX-License-Identifier: Apache-2.0
// Only what sample/DepthFeeder.kt names of it, to compile against.
package android.util;

public class Size {
  public int getWidth() { return 0; }
  public int getHeight() { return 0; }
}
