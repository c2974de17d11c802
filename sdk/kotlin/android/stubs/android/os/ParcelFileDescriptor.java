// SPDX-License-Identifier: Apache-2.0
// Only what sample-app names of it, to compile against.
package android.os;

public class ParcelFileDescriptor {
  public int getFd() { return -1; }
}
