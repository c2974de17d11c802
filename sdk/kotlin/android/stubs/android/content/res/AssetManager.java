// SPDX-License-Identifier: Apache-2.0
// Only what sample-app names of it, to compile against.
package android.content.res;

public class AssetManager {
  public AssetFileDescriptor openFd(String name) throws java.io.IOException { return null; }
}
