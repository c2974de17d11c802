// SPDX-License-Identifier: Apache-2.0
// What sample-app uses of Jetpack Compose, as it is declared there, without what is behind it. Function types lack their
// @Composable, which Kotlin 1.3 cannot read.
@file:Suppress("UNUSED_PARAMETER")

package androidx.compose.ui.graphics.drawscope

import androidx.compose.ui.geometry.Offset
import androidx.compose.ui.geometry.Size
import androidx.compose.ui.graphics.Color

abstract class DrawStyle

class Stroke(val width: Float = 0f) : DrawStyle()

interface DrawScope {
    val size: Size

    fun drawArc(
        color: Color, startAngle: Float, sweepAngle: Float, useCenter: Boolean, topLeft: Offset = Offset.Zero,
        size: Size = this.size, alpha: Float = 1f, style: DrawStyle = Stroke()
    )
}
