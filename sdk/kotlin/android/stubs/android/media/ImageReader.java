// SPDX-License-Identifier: Apache-2.0
// Only what sample/DepthFeeder.kt names of it, to compile against, and enough behind it to run in a test.
package android.media;

public class ImageReader {
  public interface OnImageAvailableListener {
    void onImageAvailable(ImageReader reader);
  }
  /* The test's: the reader made last, what it has next, and its listener. */
  public static ImageReader latest;
  public Image next;
  public OnImageAvailableListener listener;
  public boolean closed;

  public static ImageReader newInstance(int width, int height, int format, int images) { return latest = new ImageReader(); }
  public void setOnImageAvailableListener(OnImageAvailableListener to, android.os.Handler handler) { listener = to; }
  public Image acquireLatestImage() {
    if (closed) throw new IllegalStateException("the reader is closed");
    return next;
  }
  public android.view.Surface getSurface() {
    if (closed) throw new IllegalStateException("the reader is closed");
    return new android.view.Surface();
  }
  public void close() { closed = true; }
}
