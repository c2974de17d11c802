// SPDX-License-Identifier: Apache-2.0
// Only what sample-app names of it, to compile against.
package android.app;

public class Activity extends android.content.Context {
  protected void onCreate(android.os.Bundle state) {}
  protected void onStop() {}
  protected void onDestroy() {}
  public final void runOnUiThread(Runnable action) {}
}
