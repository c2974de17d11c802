// SPDX-License-Identifier: Apache-2.0
// Only what sample/DepthFeeder.kt names of it, to compile against.
package android.os;

public class Build {
  public static class VERSION {
    public static final int SDK_INT = Integer.parseInt("24");
  }
}
