// SPDX-License-Identifier: Apache-2.0
// Only what sample/DepthFeeder.kt names of it, to compile against.
package android.media;

public abstract class Image {
  public abstract static class Plane {
    public abstract java.nio.ByteBuffer getBuffer();
    public abstract int getRowStride();
  }
  public abstract Plane[] getPlanes();
  public abstract long getTimestamp();
  public abstract void close();
}
