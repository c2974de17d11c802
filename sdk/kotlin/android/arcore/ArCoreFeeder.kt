// SPDX-License-Identifier: Apache-2.0
// A sample: ARCore's raw depth, with its confidence and the pose of the phone, feeds a session. Copy it into an app that has
// com.google.ar:core 1.31 or newer. The tests compile it with stubs of ARCore's classes and run it on the golden clip. It has
// not run on a phone.
package im2fit.sample

import android.media.Image
import com.google.ar.core.Config
import com.google.ar.core.Frame
import com.google.ar.core.Session
import com.google.ar.core.TrackingState
import com.google.ar.core.exceptions.NotYetAvailableException
import im2fit.sdk.CameraModel
import im2fit.sdk.CameraPose
import im2fit.sdk.DepthFormat
import im2fit.sdk.DepthFrame
import im2fit.sdk.FitSession
import im2fit.sdk.Models
import im2fit.sdk.Progress
import im2fit.sdk.Settings
import java.io.Closeable
import java.util.ArrayDeque
import kotlin.math.abs

/**
 * Takes the frames of an ARCore session that the app owns, with `Config.DepthMode.RAW_DEPTH_ONLY`. Call [feed] and [close] on
 * the thread that calls `Session.update()`.
 *
 * A phone without a time-of-flight camera computes its depth from motion, and a person before a phone at rest gives little of
 * it. Such depth was never measured: with it use [im2fit.sdk.Turn.WALK], where the phone is carried round the person.
 *
 * @param rotateDeg `SENSOR_ORIENTATION` of the camera. 90 on nearly all phones, held upright
 * @param confidenceMin of ARCore's confidence, 0..255. Samples below it count as no data
 */
class ArCoreFeeder(
    private val models: Models, private val settings: Settings = Settings(live = true), private val rotateDeg: Int = 90,
    private val confidenceMin: Int = 128
) : Closeable {
    private class Placed(val timeNs: Long, val pose: CameraPose)

    /** Null before the first depth picture, whose size it has. Closed by [close]. */
    var session: FitSession? = null
        private set
    private val placed = ArrayDeque<Placed>()
    private var latestNs = 0L
    private var sequence = 0L

    /** The state after this frame. Null: the frame brings no new depth, or ARCore does not know where the phone is. */
    fun feed(frame: Frame): Progress? {
        val camera = frame.camera
        if (camera.trackingState != TrackingState.TRACKING) return null
        // Depth may be older than its frame. Of the physical camera, whose axes are the depth picture's.
        val pose = camera.pose
        placed.addLast(Placed(frame.timestamp, CameraPose.ofArCore(pose.rotationQuaternion, pose.translation)))
        if (placed.size > 30) placed.removeFirst()
        var depth: Image? = null
        var confidence: Image? = null
        try {
            depth = frame.acquireRawDepthImage16Bits()
            confidence = frame.acquireRawDepthConfidenceImage()
            return push(frame, depth, confidence)
        } catch (e: NotYetAvailableException) { // in the first second, or while the phone rests
            return null
        } finally {
            depth?.close()
            confidence?.close()
        }
    }

    private fun push(frame: Frame, depth: Image, confidence: Image): Progress? {
        if (depth.timestamp == latestNs) return null // seen already: ARCore returns the latest depth with each frame
        latestNs = depth.timestamp
        // minBy has another type in Kotlin 1.7 than in 1.3, and is refused between them.
        val pose = placed.reduce { a, b -> if (abs(b.timeNs - depth.timestamp) < abs(a.timeNs - depth.timestamp)) b else a }
        if (abs(pose.timeNs - depth.timestamp) > 50_000_000) return null
        // Those of the colour texture. Half a pixel is half a pixel at any scale: the centre of pixel 0 is 0.
        val lens = frame.camera.textureIntrinsics
        val scale = depth.width.toFloat() / lens.imageDimensions[0]
        val camera = CameraModel(
            depth.width, depth.height, lens.focalLength[0] * scale, lens.focalLength[1] * scale,
            (lens.principalPoint[0] + 0.5f) * scale - 0.5f, (lens.principalPoint[1] + 0.5f) * scale - 0.5f, rotateDeg
        )
        val session = this.session ?: FitSession(camera, models, settings).also { this.session = it }
        val (samples, sure) = listOf(depth.planes[0], confidence.planes[0])
        // U16, not DEPTH16: all 16 bits are millimetres.
        session.push(
            DepthFrame(
                samples.buffer, DepthFormat.U16, samples.rowStride, depth.timestamp, sequence++, sure.buffer, sure.rowStride,
                confidenceMin, camera, pose = pose.pose
            )
        )
        return session.progress()
    }

    /** A second call does nothing more. */
    override fun close() {
        session?.close()
    }

    companion object {
        /** Whether ARCore has raw depth on this device. Ask before anybody undresses. */
        fun isAvailable(session: Session): Boolean = session.isDepthModeSupported(Config.DepthMode.RAW_DEPTH_ONLY)
    }
}
