// SPDX-License-Identifier: Apache-2.0
// Only what sample-app names of it, to compile against.
package android;

public final class Manifest {
  public static final class permission {
    public static final String CAMERA = "android.permission.CAMERA";
  }
}
