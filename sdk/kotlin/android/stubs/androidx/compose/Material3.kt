// SPDX-License-Identifier: Apache-2.0
// What sample-app uses of Jetpack Compose, as it is declared there, without what is behind it. Function types lack their
// @Composable, which Kotlin 1.3 cannot read.
@file:Suppress("UNUSED_PARAMETER")

package androidx.compose.material3

import androidx.compose.runtime.Composable
import androidx.compose.ui.Modifier
import androidx.compose.ui.text.TextStyle

class Typography {
    val headlineMedium: TextStyle = TextStyle()
}

object MaterialTheme {
    val typography: Typography
        @Composable get() = Typography()
}

@Composable
fun MaterialTheme(content: () -> Unit) = Unit

@Composable
fun Surface(modifier: Modifier = Modifier, content: () -> Unit) = Unit

@Composable
fun Text(text: String, modifier: Modifier = Modifier, style: TextStyle = TextStyle()) = Unit

@Composable
fun Button(onClick: () -> Unit, modifier: Modifier = Modifier, content: () -> Unit) = Unit

@Composable
fun OutlinedButton(onClick: () -> Unit, modifier: Modifier = Modifier, content: () -> Unit) = Unit

@Composable
fun LinearProgressIndicator(progress: () -> Float, modifier: Modifier = Modifier) = Unit
