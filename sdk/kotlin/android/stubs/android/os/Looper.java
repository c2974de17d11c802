// SPDX-License-Identifier: Apache-2.0
// Only what sample-app names of it, to compile against.
package android.os;

public final class Looper {}
