// SPDX-License-Identifier: Apache-2.0
// Only what sample/DepthFeeder.kt names of it, to compile against.
package android.hardware;

public class Sensor {
  public static final int TYPE_GRAVITY = 9;
}
