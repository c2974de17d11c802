// SPDX-License-Identifier: Apache-2.0
// Only what sample-app names of it, to compile against.
package androidx.activity.result;

public abstract class ActivityResultLauncher<I> {
  public void launch(I input) {}
}
