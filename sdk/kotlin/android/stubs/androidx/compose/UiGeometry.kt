// SPDX-License-Identifier: Apache-2.0
// What sample-app uses of Jetpack Compose, as it is declared there, without what is behind it. Function types lack their
// @Composable, which Kotlin 1.3 cannot read.
@file:Suppress("UNUSED_PARAMETER")

package androidx.compose.ui.geometry

class Offset(val x: Float, val y: Float) {
    companion object {
        val Zero: Offset = Offset(0f, 0f)
    }
}

class Size(val width: Float, val height: Float)
