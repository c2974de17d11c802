// SPDX-License-Identifier: Apache-2.0
// Only what sample-app names of it, to compile against.
package androidx.activity.result.contract;

public abstract class ActivityResultContract<I, O> {}
