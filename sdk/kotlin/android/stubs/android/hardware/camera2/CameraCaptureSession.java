// SPDX-License-Identifier: Apache-2.0
// Only what sample/DepthFeeder.kt names of it, to compile against.
package android.hardware.camera2;

public class CameraCaptureSession {
  public abstract static class StateCallback {
    public abstract void onConfigured(CameraCaptureSession session);
    public abstract void onConfigureFailed(CameraCaptureSession session);
  }
  public abstract static class CaptureCallback {}
  public int setRepeatingRequest(CaptureRequest request, CaptureCallback listener, android.os.Handler handler) { return 0; }
}
