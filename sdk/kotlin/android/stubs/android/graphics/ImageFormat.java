// SPDX-License-Identifier: Apache-2.0
// Only what sample/DepthFeeder.kt names of it, to compile against.
package android.graphics;

public class ImageFormat {
  public static final int DEPTH16 = 0x44363159;
}
