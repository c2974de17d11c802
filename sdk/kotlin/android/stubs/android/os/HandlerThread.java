// SPDX-License-Identifier: Apache-2.0
// Only what sample-app names of it, to compile against.
package android.os;

public class HandlerThread extends Thread {
  public HandlerThread(String name) { super(name); }
  public Looper getLooper() { return null; }
  public boolean quitSafely() { return true; }
}
