// SPDX-License-Identifier: Apache-2.0
// What sample-app uses of Jetpack Compose, as it is declared there, without what is behind it. Function types lack their
// @Composable, which Kotlin 1.3 cannot read.
@file:Suppress("UNUSED_PARAMETER")

package androidx.compose.runtime

@Target(AnnotationTarget.FUNCTION, AnnotationTarget.TYPE, AnnotationTarget.PROPERTY_GETTER)
annotation class Composable

abstract class CompositionContext

interface State<out T> {
    val value: T
}

interface MutableState<T> : State<T> {
    override var value: T
}

fun <T> mutableStateOf(value: T): MutableState<T> = object : MutableState<T> {
    override var value: T = value
}
