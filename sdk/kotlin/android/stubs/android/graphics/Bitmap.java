// SPDX-License-Identifier: Apache-2.0
// Only what sample-app names of it, to compile against.
package android.graphics;

public final class Bitmap {
  public enum Config { ARGB_8888 }
  public static Bitmap createBitmap(int[] colors, int width, int height, Config config) { return new Bitmap(); }
}
