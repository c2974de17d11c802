// SPDX-License-Identifier: Apache-2.0
// Only what sample-app names of it, to compile against.
package android.content.res;

public class AssetFileDescriptor implements java.io.Closeable {
  public android.os.ParcelFileDescriptor getParcelFileDescriptor() { return null; }
  public long getStartOffset() { return 0; }
  public long getLength() { return 0; }
  @Override
  public void close() {}
}
