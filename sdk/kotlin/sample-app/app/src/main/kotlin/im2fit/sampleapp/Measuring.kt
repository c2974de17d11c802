// SPDX-License-Identifier: Apache-2.0
// One visit: may this phone measure, may we use the camera, the measurement, the result, its deletion. No screen is in
// here; the tests run it on stubs of Android's classes. sdk/swift/SampleApp has the same steps.
package im2fit.sampleapp

import android.content.Context
import android.os.Handler
import im2fit.sample.DepthFeeder
import im2fit.sdk.Guidance
import im2fit.sdk.Mask
import im2fit.sdk.Models
import im2fit.sdk.Outcome
import im2fit.sdk.Person
import im2fit.sdk.Progress
import im2fit.sdk.Settings
import im2fit.sdk.State
import im2fit.sdk.Turn

/** What the screen shows. */
enum class Step {
    /** No depth camera: said before anybody undresses. */
    UNSUPPORTED,
    /** The camera's permission is needed. */
    PERMISSION,
    /** What happens, and a button that consents to it. */
    READY,
    MEASURING,
    RESULT,
    /** Stopped too early; [Shown.guidance] says what was in the way. */
    NOT_MEASURED,
    FAILED
}

/** All that a screen needs. A new one for each change. */
data class Shown(
    val step: Step, val progress: Progress? = null, val mask: Mask? = null, val person: Person? = null,
    val guidance: Set<Guidance> = emptySet(), val failure: String? = null
)

/** Opens the models and calls its argument while they are open. */
typealias ModelSource = ((Models) -> DepthFeeder) -> DepthFeeder

/**
 * @param handler of the camera's thread
 * @param onScreen runs its argument on the screen's thread, where [onChange] is called and all functions are to be called
 */
class Measuring(
    private val context: Context, private val models: ModelSource, private val handler: Handler,
    private val onScreen: (() -> Unit) -> Unit, private val onChange: (Shown) -> Unit
) : AutoCloseable {
    @Volatile private var feeder: DepthFeeder? = null
    private var visit = 0 // what a camera that is closed still reports belongs to an earlier one

    var shown = Shown(if (DepthFeeder.isAvailable(context)) Step.PERMISSION else Step.UNSUPPORTED)
        private set(value) {
            field = value
            onChange(value)
        }

    /** The person's answer to the question for the camera. */
    fun granted(yes: Boolean) {
        if (shown.step == Step.PERMISSION && yes) shown = Shown(Step.READY)
    }

    /** The person consents. [turn]: with a slow turn on the spot, which measures waist and hip better. */
    fun start(turn: Boolean) {
        if (shown.step !in listOf(Step.READY, Step.NOT_MEASURED, Step.FAILED)) return
        stopCamera()
        val mine = ++visit
        val settings = Settings(turn = if (turn) Turn.AROUND else Turn.NONE)
        try {
            feeder = models { opened ->
                DepthFeeder(
                    context, opened, handler, settings,
                    onFailure = { failure -> report(mine) { fail(failure.message) } },
                    onProgress = { progress -> seen(mine, progress) }
                )
            }
            shown = Shown(Step.MEASURING)
            feeder!!.start()
        } catch (e: Exception) { // no models, no calibration of the camera, no camera
            fail(e.message)
        }
    }

    /** Ends with the frames so far. Measuring takes some tenths of a second, so not on the screen's thread. */
    fun stop() {
        val session = feeder?.session ?: return
        val mine = visit
        handler.post { guarded(mine) { session.finish().let { report(mine) { end(it) } } } }
    }

    /** Nothing of the person is left: no file was written, and the session with its frames is closed. */
    fun delete() {
        stopCamera()
        if (shown.step != Step.UNSUPPORTED && shown.step != Step.PERMISSION) shown = Shown(Step.READY)
    }

    /** The app is not on the screen any more: the camera goes off, and a measurement that has begun is dropped. */
    fun leave() {
        stopCamera()
        if (shown.step == Step.MEASURING) shown = Shown(Step.READY)
    }

    override fun close() = stopCamera()

    /** On the camera's thread, from the first frame on: the feeder is made by then. */
    private fun seen(mine: Int, progress: Progress) = guarded(mine) {
        val session = feeder?.session ?: return@guarded
        if (progress.state == State.MEASURED) {
            val outcome = session.outcome()
            report(mine) { end(outcome) }
        } else {
            val mask = session.mask()
            report(mine) { shown = Shown(Step.MEASURING, progress, mask) }
        }
    }

    /** No exception may reach the camera's thread. One of a session that the screen has closed meanwhile concerns nobody. */
    private fun guarded(mine: Int, what: () -> Unit) {
        try {
            what()
        } catch (e: RuntimeException) {
            report(mine) { fail(e.message) }
        }
    }

    private fun report(mine: Int, what: () -> Unit) = onScreen { if (mine == visit && shown.step == Step.MEASURING) what() }

    private fun end(outcome: Outcome) {
        stopCamera()
        shown = when (outcome) {
            is Outcome.Measured -> Shown(Step.RESULT, person = outcome.person)
            is Outcome.NotMeasured -> Shown(Step.NOT_MEASURED, guidance = outcome.guidance)
        }
    }

    private fun fail(message: String?) {
        stopCamera()
        shown = Shown(Step.FAILED, failure = message)
    }

    private fun stopCamera() {
        ++visit
        feeder?.close()
        feeder = null
    }
}
