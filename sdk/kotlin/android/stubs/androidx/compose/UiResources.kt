// SPDX-License-Identifier: Apache-2.0
// What sample-app uses of Jetpack Compose, as it is declared there, without what is behind it. Function types lack their
// @Composable, which Kotlin 1.3 cannot read.
@file:Suppress("UNUSED_PARAMETER")

package androidx.compose.ui.res

import androidx.compose.runtime.Composable

@Composable
fun stringResource(id: Int): String = ""

@Composable
fun stringResource(id: Int, vararg formatArgs: Any): String = ""
