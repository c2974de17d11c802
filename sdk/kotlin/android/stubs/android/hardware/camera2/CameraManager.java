// SPDX-License-Identifier: Apache-2.0
// Only what sample/DepthFeeder.kt names of it, to compile against.
package android.hardware.camera2;

public class CameraManager {
  public String[] getCameraIdList() { return null; }
  public CameraCharacteristics getCameraCharacteristics(String id) { return null; }
  public void openCamera(String id, CameraDevice.StateCallback callback, android.os.Handler handler) {}
}
