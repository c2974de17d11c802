// SPDX-License-Identifier: Apache-2.0
// For apps that have kotlinx-coroutines, 1.4 or newer: copy it into the app. The package itself needs none; in our tests this
// is compiled against, and runs on, stubs of what it uses.
package im2fit.sample

import im2fit.sdk.Frame
import im2fit.sdk.Progress
import im2fit.sdk.Session
import im2fit.sdk.State
import kotlinx.coroutines.Dispatchers
import kotlinx.coroutines.flow.Flow
import kotlinx.coroutines.flow.emitAll
import kotlinx.coroutines.flow.flow
import kotlinx.coroutines.flow.flowOn
import kotlinx.coroutines.flow.transformWhile

/**
 * Pushes [frames] as they come, until the measurement, and gives the session's state each time the person is to be told
 * something else: [Session.states] for a camera that is a flow. Nothing happens before the flow is collected; after it
 * [Session.outcome] has the answer. Frames are pushed on a thread of `Dispatchers.Default`, whoever collects.
 */
fun Session.states(frames: Flow<Frame>): Flow<Progress> = flow<Progress> {
    var before: Progress? = null
    emitAll(frames.transformWhile<Frame, Progress> { frame ->
        push(frame)
        val now = progress()
        if (now.saysMoreThan(before)) emit(now)
        before = now
        now.state != State.MEASURED
    })
}.flowOn(Dispatchers.Default)
