// SPDX-License-Identifier: Apache-2.0
// What sample-app uses of Jetpack Compose, as it is declared there, without what is behind it. Function types lack their
// @Composable, which Kotlin 1.3 cannot read.
@file:Suppress("UNUSED_PARAMETER")

package androidx.compose.foundation

import androidx.compose.runtime.Composable
import androidx.compose.ui.Modifier
import androidx.compose.ui.graphics.ImageBitmap
import androidx.compose.ui.graphics.drawscope.DrawScope

class ScrollState

@Composable
fun rememberScrollState(initial: Int = 0): ScrollState = ScrollState()

fun Modifier.verticalScroll(state: ScrollState, enabled: Boolean = true): Modifier = this

@Composable
fun Canvas(modifier: Modifier, onDraw: DrawScope.() -> Unit) = Unit

@Composable
fun Image(bitmap: ImageBitmap, contentDescription: String?, modifier: Modifier = Modifier) = Unit
