// SPDX-License-Identifier: Apache-2.0
// Only what sample-app names of it, to compile against.
package android.content.pm;

public abstract class PackageManager {
  public static final int PERMISSION_GRANTED = 0;
}
