// SPDX-License-Identifier: Apache-2.0
// Only what sample/DepthFeeder.kt names of it, to compile against.
package android.media;

public class ImageReader {
  public interface OnImageAvailableListener {
    void onImageAvailable(ImageReader reader);
  }
  public static ImageReader newInstance(int width, int height, int format, int images) { return null; }
  public void setOnImageAvailableListener(OnImageAvailableListener listener, android.os.Handler handler) {}
  public Image acquireLatestImage() { return null; }
  public android.view.Surface getSurface() { return null; }
  public void close() {}
}
