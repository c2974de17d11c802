// SPDX-License-Identifier: Apache-2.0
// Only what sample/DepthFeeder.kt names of it, to compile against.
package android.hardware.camera2.params;

public class StreamConfigurationMap {
  public android.util.Size[] getOutputSizes(int format) { return null; }
}
