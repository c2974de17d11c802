// SPDX-License-Identifier: Apache-2.0
// Only what sample/DepthFeeder.kt names of it, to compile against.
package android.hardware.camera2;

public abstract class CameraDevice {
  public static final int TEMPLATE_PREVIEW = 1;
  public abstract static class StateCallback {
    public abstract void onOpened(CameraDevice camera);
    public abstract void onDisconnected(CameraDevice camera);
    public abstract void onError(CameraDevice camera, int error);
  }
  public abstract CaptureRequest.Builder createCaptureRequest(int template);
  public abstract void createCaptureSession(java.util.List<android.view.Surface> outputs, CameraCaptureSession.StateCallback callback,
      android.os.Handler handler);
  public abstract void close();
}
