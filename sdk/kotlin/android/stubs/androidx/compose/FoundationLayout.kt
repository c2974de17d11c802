// SPDX-License-Identifier: Apache-2.0
// What sample-app uses of Jetpack Compose, as it is declared there, without what is behind it. Function types lack their
// @Composable, which Kotlin 1.3 cannot read.
@file:Suppress("UNUSED_PARAMETER")

package androidx.compose.foundation.layout

import androidx.compose.runtime.Composable
import androidx.compose.ui.Alignment
import androidx.compose.ui.Modifier
import androidx.compose.ui.unit.Dp

interface BoxScope

interface ColumnScope

object Arrangement {
    interface Vertical
    interface HorizontalOrVertical : Vertical

    val Top: Vertical = object : Vertical {}
    val SpaceBetween: HorizontalOrVertical = object : HorizontalOrVertical {}
    fun spacedBy(space: Dp): HorizontalOrVertical = object : HorizontalOrVertical {}
}

fun Modifier.fillMaxSize(fraction: Float = 1f): Modifier = this
fun Modifier.fillMaxWidth(fraction: Float = 1f): Modifier = this
fun Modifier.padding(all: Dp): Modifier = this
fun Modifier.safeDrawingPadding(): Modifier = this

@Composable
fun Box(
    modifier: Modifier = Modifier, contentAlignment: Alignment = Alignment.Center, propagateMinConstraints: Boolean = false,
    content: BoxScope.() -> Unit
) = Unit

@Composable
fun Column(
    modifier: Modifier = Modifier, verticalArrangement: Arrangement.Vertical = Arrangement.Top,
    horizontalAlignment: Alignment.Horizontal = Alignment.Start, content: ColumnScope.() -> Unit
) = Unit
