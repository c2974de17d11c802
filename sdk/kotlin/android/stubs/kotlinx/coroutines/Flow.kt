// SPDX-License-Identifier: Apache-2.0
// What android/coroutines uses of kotlinx-coroutines, as it is declared there, and enough behind it to run in a test.
package kotlinx.coroutines.flow

import kotlin.coroutines.CoroutineContext

interface FlowCollector<in T> {
    suspend fun emit(value: T)
}

interface Flow<out T> {
    suspend fun collect(collector: FlowCollector<T>)
}

fun <T> flow(block: suspend FlowCollector<T>.() -> Unit): Flow<T> = object : Flow<T> {
    override suspend fun collect(collector: FlowCollector<T>) = collector.block()
}

suspend fun <T> FlowCollector<T>.emitAll(flow: Flow<T>) = flow.collect(this)

private class Stopped(val by: Any) : RuntimeException()

fun <T, R> Flow<T>.transformWhile(transform: suspend FlowCollector<R>.(T) -> Boolean): Flow<R> {
    val upstream = this
    return flow<R> {
        val down = this
        val mine = Any()
        try {
            upstream.collect(object : FlowCollector<T> {
                override suspend fun emit(value: T) {
                    if (!down.transform(value)) throw Stopped(mine)
                }
            })
        } catch (stopped: Stopped) {
            if (stopped.by !== mine) throw stopped
        }
    }
}

@Suppress("UNUSED_PARAMETER")
fun <T> Flow<T>.flowOn(context: CoroutineContext): Flow<T> = this
