// SPDX-License-Identifier: Apache-2.0
// For apps with kotlinx-coroutines 1.4 or newer: copy it into the app. The package itself has no dependencies. The tests
// compile and run this file with stubs of its dependencies.
package im2fit.sample

import im2fit.sdk.DepthFrame
import im2fit.sdk.FitSession
import im2fit.sdk.Progress
import im2fit.sdk.State
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.emitAll
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.flow.flowOn
import kotlinx.coroutines.flow.transformWhile

/**
 * Pushes [frames] as they come, until the measurement. Emits the progress each time that the display for the person
 * changes: [FitSession.states] for a camera that is a flow. The flow is cold. When it ends, [FitSession.outcome] has the result.
 * Frames are pushed on a thread of `Dispatchers.Default`, whichever thread collects.
 */
fun FitSession.states(frames: Flow<DepthFrame>): Flow<Progress> = flow<Progress> {
    var before: Progress? = null
    emitAll(frames.transformWhile<DepthFrame, Progress> { frame ->
        push(frame)
        val now = progress()
        if (now.saysMoreThan(before)) emit(now)
        before = now
        now.state != State.MEASURED
    })
}.flowOn(Dispatchers.Default)
