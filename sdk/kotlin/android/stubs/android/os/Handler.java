// SPDX-License-Identifier: Apache-2.0
// Only what sample/DepthFeeder.kt and sample-app name of it, to compile against, and enough behind it to run in a test.
package android.os;

public class Handler {
  public Handler() {}
  public Handler(Looper looper) {}
  public final boolean post(Runnable action) {
    action.run();
    return true;
  }
}
