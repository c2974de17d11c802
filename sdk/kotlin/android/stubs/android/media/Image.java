// SPDX-License-Identifier: Apache-2.0
// Only what sample/DepthFeeder.kt and arcore/ArCoreFeeder.kt name of it, to compile against.
package android.media;

public abstract class Image implements AutoCloseable {
  public abstract static class Plane {
    public abstract java.nio.ByteBuffer getBuffer();
    public abstract int getRowStride();
  }
  public abstract Plane[] getPlanes();
  public int getWidth() { return 0; }
  public int getHeight() { return 0; }
  public abstract long getTimestamp();
  @Override
  public abstract void close();
}
