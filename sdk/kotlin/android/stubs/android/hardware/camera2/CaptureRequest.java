// SPDX-License-Identifier: Apache-2.0
// Only what sample/DepthFeeder.kt names of it, to compile against.
package android.hardware.camera2;

public class CaptureRequest {
  public static class Builder {
    public void addTarget(android.view.Surface surface) {}
    public CaptureRequest build() { return null; }
  }
}
